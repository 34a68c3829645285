import { Alert, Button, Group, Skeleton, Stack, TagsInput, Text, Textarea, TextInput } from "@mantine/core";
import { useQueryClient } from "@tanstack/react-query";
import { type FormEvent, type KeyboardEvent, useMemo, useState } from "react";
import { MAX_NAME, ownName, setOwnName } from "../access/who";
import { createNotesApi, type Note, type NotesApi } from "../api/goals";
import { LIMITS } from "../api/limits.gen";
import { useFleet, useWhyNot } from "../fleet/context";
import { isConflict } from "../ui/Conflict";
import { CommandErrorAlert, Trouble } from "../ui/errors";
import { ReasonButton } from "../ui/ReasonButton";
import { useAnswer, useCommand } from "../ui/requests";
import { Section } from "../ui/Section";
import { Time } from "../ui/Time";
import classes from "./goalPage.module.css";
import { TAGS_KEY, useTags } from "./TagSelect";

/** What people say about a goal: its tags, and notes with their authors. */
export function NotesSection({ goalId }: { goalId: string }) {
  const { notes, error, refetch, change } = useNotes(goalId);
  const reason =
    useWhyNot("POST /goals/{goal_id}/notes") ?? (change.isPending ? "The last change is being saved." : null);
  return (
    <Section title="Notes" help="dashboard#notes-and-tags-on-goals">
      <Trouble what="The notes could not be loaded" error={error} onRetry={() => void refetch()} />
      {notes === null ? (
        error === null && <Skeleton height={110} />
      ) : (
        <Stack gap="sm">
          <TagsField
            tags={notes.tags.tags}
            reason={reason}
            onTags={(tags) => change.mutate((api) => api.setTags(notes.tags, tags))}
          />
          <NoteList
            notes={notes.notes}
            reason={reason}
            onRemove={(note) => change.mutate((api) => api.remove(note))}
          />
          <NoteForm
            reason={reason}
            onAdd={(by, text, done) =>
              change.mutate((api) => api.add(by, text), {
                onSuccess: done,
              })
            }
          />
        </Stack>
      )}
      {isConflict(change.error) ? (
        <Alert
          color="orange"
          role="alert"
          title="Someone else has changed the tags meanwhile"
          withCloseButton
          closeButtonLabel="Dismiss"
          onClose={change.reset}
        >
          Your change is not saved. The tags are shown as they are now: change them again.
        </Alert>
      ) : (
        <CommandErrorAlert command="Saving" error={change.error} onClose={change.reset} />
      )}
    </Section>
  );
}

const { maxLength: MAX_TEXT } = LIMITS["POST /goals/{goal_id}/notes"].text;

interface NoteFormProps {
  /** Why none can be added now; null where it can. */
  reason: string | null;
  onAdd: (by: string, text: string, done: () => void) => void;
}

/** Adds a note with the name that was given on this computer; asks for one where there is none. */
function NoteForm({ reason, onAdd }: NoteFormProps) {
  const [text, setText] = useState("");
  const [known, setKnown] = useState(() => ownName().trim());
  const [name, setName] = useState("");
  const by = known || name.trim();
  const missing =
    reason ?? (text.trim() === "" ? "Write something first." : by === "" ? "Enter your name first." : null);
  const add = () => {
    if (missing !== null) return;
    if (known === "") setOwnName(by);
    setKnown(by);
    onAdd(by, text, () => setText(""));
  };
  const submit = (event: FormEvent) => {
    event.preventDefault();
    add();
  };
  const press = (event: KeyboardEvent) => {
    if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) add();
  };
  return (
    <form onSubmit={submit}>
      <Textarea
        aria-label="New note"
        placeholder="What happened?"
        rows={2}
        resize="vertical"
        maxLength={MAX_TEXT}
        value={text}
        onChange={(event) => setText(event.currentTarget.value)}
        onKeyDown={press}
      />
      <Group gap="xs" mt="xs" justify="flex-end">
        {known === "" ? (
          <TextInput
            aria-label="Your name"
            placeholder="Your name"
            autoComplete="name"
            size="xs"
            maxLength={MAX_NAME}
            value={name}
            onChange={(event) => setName(event.currentTarget.value)}
          />
        ) : (
          <Text size="sm" c="dimmed">
            as {known}
          </Text>
        )}
        <ReasonButton type="submit" variant="default" size="xs" reason={missing}>
          Add note
        </ReasonButton>
      </Group>
    </form>
  );
}

interface NoteListProps {
  notes: readonly Note[];
  /** Why none can be deleted now; null where they can. */
  reason: string | null;
  onRemove: (noteId: string) => void;
}

/** Oldest first. */
function NoteList({ notes, reason, onRemove }: NoteListProps) {
  if (notes.length === 0) return null;
  return (
    <ul className={classes.notes} aria-label="Notes">
      {notes.map((note) => (
        <li key={note.id} className={classes.note}>
          <Group justify="space-between" gap="xs" align="start" wrap="nowrap">
            <Text size="sm" c="dimmed">
              <Text span fw={600} c="var(--mantine-color-text)">
                {note.by}
              </Text>{" "}
              <Time value={note.created_at} />
            </Text>
            <DeleteButton note={note} reason={reason} onDelete={() => onRemove(note.id)} />
          </Group>
          <Text size="sm" className={classes.noteText}>
            {note.text}
          </Text>
        </li>
      ))}
    </ul>
  );
}

interface DeleteButtonProps {
  note: Note;
  reason: string | null;
  onDelete: () => void;
}

/** Deletes when it is pressed twice: a note that was deleted is gone. */
function DeleteButton({ note, reason, onDelete }: DeleteButtonProps) {
  const [asked, setAsked] = useState(false);
  return (
    <Group gap={4} wrap="nowrap" flex="none">
      {asked && (
        <Button variant="subtle" color="gray" size="compact-xs" onClick={() => setAsked(false)}>
          Keep
        </Button>
      )}
      <ReasonButton
        variant={asked ? "filled" : "subtle"}
        color={asked ? "red" : "gray"}
        c={asked ? undefined : "dimmed"}
        size="compact-xs"
        reason={reason}
        aria-label={asked ? `Really delete the note by ${note.by}` : `Delete the note by ${note.by}`}
        onClick={() => (asked ? onDelete() : setAsked(true))}
      >
        {asked ? "Really delete" : "Delete"}
      </ReasonButton>
    </Group>
  );
}

const { tags: TAGS, "tags[]": TAG } = LIMITS["PUT /goals/{goal_id}/tags"];

interface TagsFieldProps {
  tags: readonly string[];
  /** Why they cannot be changed now; null where they can. */
  reason: string | null;
  onTags: (tags: string[]) => void;
}

/** The tags of a goal, saved as they are added and removed. */
function TagsField({ tags, reason, onTags }: TagsFieldProps) {
  const known = useTags();
  return (
    <TagsInput
      aria-label="Tags"
      placeholder={tags.length < TAGS.maxItems ? "Add a tag" : ""}
      data={[...known]}
      maxTags={TAGS.maxItems}
      maxLength={TAG.maxLength}
      value={[...tags]}
      onChange={(next) => reason === null && onTags(next)}
      readOnly={reason !== null}
      title={reason ?? undefined}
      comboboxProps={{ withinPortal: false }}
      acceptValueOnBlur
    />
  );
}

/** How often other people's notes are asked for (ms). */
const REFETCH_MS = 5000;

/** The notes and tags of a goal, and what changes them. */
function useNotes(goalId: string) {
  const { http } = useFleet();
  const client = useQueryClient();
  const api = useMemo(() => createNotesApi(http, goalId), [http, goalId]);
  const key = ["notes", goalId];
  const { data, error, refetch } = useAnswer({
    queryKey: key,
    queryFn: () => api.read(),
    refetchInterval: REFETCH_MS,
  });
  const change = useCommand(async (send: (api: NotesApi) => Promise<unknown>) => {
    try {
      await send(api);
    } finally {
      await client.invalidateQueries({ queryKey: key }); // also what is being read now is outdated
    }
    void client.invalidateQueries({ queryKey: TAGS_KEY });
  });
  return { notes: data ?? null, error, refetch, change };
}
