import type { ClientError } from "@dock-gateway/client";
import { Stack, TextInput } from "@mantine/core";
import type { UseMutationResult } from "@tanstack/react-query";
import { type FormEvent, type ReactNode, useState } from "react";
import { NameInput, ownName, setOwnName } from "../access/who";
import { SaveBar } from "../ui/Dialog";
import { newId } from "../ui/text";

interface EntryFormProps<Draft extends { name: string }, Errors extends { name?: string }, Body, Stored> {
  /** What it is: `rule`. */
  noun: string;
  /** The id of the entry that is changed; undefined for a new one. */
  id: string | undefined;
  /** What the form starts from. */
  start: Draft;
  /** All of them. */
  entries: readonly { id: string }[];
  /** A name, as an example, and how long one may be. */
  placeholder: string;
  maxName: number;
  /** What is wrong with each field. */
  errorsOf: (draft: Draft) => Errors;
  /** The request that stores it; `by` is null where no name is given. */
  bodyOf: (draft: Draft, by: string | null) => Body;
  save: UseMutationResult<Stored, ClientError, { id: string; body: Body }>;
  onSaved: (stored: Stored) => void;
  onCancel: () => void;
  /** The fields between its name and that of who saves it; errors are shown from the first try on. */
  children: (draft: Draft, errors: Partial<Errors>, change: (part: Partial<Draft>) => void) => ReactNode;
}

/** Adds or changes something that is stored under a name, such as a rule or a webhook. */
export function EntryForm<Draft extends { name: string }, Errors extends { name?: string }, Body, Stored>({
  noun,
  id,
  start,
  entries,
  placeholder,
  maxName,
  errorsOf,
  bodyOf,
  save,
  onSaved,
  onCancel,
  children,
}: EntryFormProps<Draft, Errors, Body, Stored>) {
  const [draft, setDraft] = useState(start);
  const [by, setBy] = useState(ownName);
  const [tried, setTried] = useState(false);
  const errors = errorsOf(draft);
  const shown: Partial<Errors> = tried ? errors : {};
  const change = (part: Partial<Draft>) => setDraft((before) => ({ ...before, ...part }));
  const submit = (event: FormEvent) => {
    event.preventDefault();
    setTried(true);
    if (Object.keys(errors).length > 0) return;
    setOwnName(by.trim());
    const taken = entries.map((entry) => entry.id);
    const body = bodyOf(draft, by.trim() || null);
    save.mutate({ id: id ?? newId(draft.name, taken, noun), body }, { onSuccess: onSaved });
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
        <SaveBar save={save} onCancel={onCancel} />
      </Stack>
    </form>
  );
}
