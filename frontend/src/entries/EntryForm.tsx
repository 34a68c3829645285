import type { ClientError } from "@dock-gateway/client";
import { Stack, TextInput } from "@mantine/core";
import type { UseMutationResult } from "@tanstack/react-query";
import { type FormEvent, type ReactNode, useState } from "react";
import { NameInput, ownName, setOwnName } from "../access/who";
import type { Base } from "../api/version";
import { Conflict, isConflict } from "../ui/Conflict";
import { SaveBar } from "../ui/Dialog";
import { newId } from "../ui/text";

interface EntryBase {
  id: string;
  etag: string;
  changed_by: string | null;
}

/** Changes fields of a draft; by a function, they depend on what the draft is then. */
type Change<Draft> = (part: Partial<Draft> | ((before: Draft) => Partial<Draft>)) => void;

interface EntryFormProps<
  Entry extends EntryBase,
  Draft extends { name: string },
  Errors extends { name?: string },
  Body,
  Stored,
> {
  /** What it is: `rule`. */
  noun: string;
  /** The entry that is changed; null for a new one. */
  entry: Entry | null;
  /** The fields of an entry. */
  draftOf: (entry: Entry | null) => Draft;
  /** What a new one starts from. */
  example: Partial<Draft> | undefined;
  /** All entries, as they are stored now. */
  entries: readonly Entry[];
  /** A name, as an example, and how long one may be. */
  placeholder: string;
  maxName: number;
  /** What is wrong with each field. */
  errorsOf: (draft: Draft) => Errors;
  /** The request that stores it in place of an entry, or as a new one; `by` is null where no name is given. */
  bodyOf: (draft: Draft, by: string | null, replaced: Entry | null) => Body;
  save: UseMutationResult<Stored, ClientError, { id: string; body: Body; base: Base }>;
  /** Marks what the gateway has refused where the draft has a place for it. */
  refused?: (draft: Draft, error: ClientError) => Partial<Draft>;
  onSaved: (stored: Stored) => void;
  onCancel: () => void;
  /** The fields between its name and that of who saves it; errors are shown from the first try on. */
  children: (draft: Draft, errors: Partial<Errors>, change: Change<Draft>) => ReactNode;
}

/** Adds or changes something that is stored under a name, such as a rule or a webhook. */
export function EntryForm<
  Entry extends EntryBase,
  Draft extends { name: string },
  Errors extends { name?: string },
  Body,
  Stored,
>({
  noun,
  entry,
  draftOf,
  example,
  entries,
  placeholder,
  maxName,
  errorsOf,
  bodyOf,
  save,
  refused = () => ({}),
  onSaved,
  onCancel,
  children,
}: EntryFormProps<Entry, Draft, Errors, Body, Stored>) {
  /** What the draft is based on. */
  const [base, setBase] = useState(entry);
  const [draft, setDraft] = useState<Draft>({ ...draftOf(entry), ...example });
  const [by, setBy] = useState(ownName);
  const [tried, setTried] = useState(false);
  const errors = errorsOf(draft);
  const shown: Partial<Errors> = tried ? errors : {};
  const change: Change<Draft> = (part) =>
    setDraft((before) => ({ ...before, ...(typeof part === "function" ? part(before) : part) }));
  const store = (replaced: Entry | null) => {
    setTried(true);
    if (Object.keys(errors).length > 0) return;
    setOwnName(by.trim());
    setBase(replaced);
    const taken = entries.map(({ id }) => id);
    const body = bodyOf(draft, by.trim() || null, replaced);
    const id = entry?.id ?? newId(draft.name, taken, noun);
    save.mutate(
      { id, body, base: replaced },
      { onSuccess: onSaved, onError: (error) => change((before) => refused(before, error)) },
    );
  };
  const submit = (event: FormEvent) => {
    event.preventDefault();
    store(base);
  };
  const show = (newest: Entry) => {
    setBase(newest);
    setDraft(draftOf(newest));
    save.reset();
  };
  return (
    <form onSubmit={submit} noValidate>
      <Stack gap="md">
        <TextInput
          label="Name"
          placeholder={placeholder}
          maxLength={maxName}
          value={draft.name}
          error={shown.name}
          onChange={(event) => change({ name: event.currentTarget.value } as Partial<Draft>)}
          data-autofocus
        />
        {children(draft, shown, change)}
        <NameInput value={by} description={`Shown with the ${noun}.`} onChange={setBy} />
        <SaveBar
          save={save}
          onCancel={onCancel}
          trouble={
            isConflict(save.error) && (
              <Conflict newest={entries.find(({ id }) => id === entry?.id)} onShow={show} onReplace={store} />
            )
          }
        />
      </Stack>
    </form>
  );
}
