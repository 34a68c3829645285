import { Group, Text } from "@mantine/core";
import { useState } from "react";
import type { Note } from "../api/notes";
import { ReasonButton } from "../ui/ReasonButton";
import { Time } from "../ui/Time";
import classes from "./goalPage.module.css";

interface NoteListProps {
  notes: readonly Note[];
  /** Why none can be deleted now; null where they can. */
  reason: string | null;
  onRemove: (noteId: string) => void;
}

/** Oldest first. */
export function NoteList({ notes, reason, onRemove }: NoteListProps) {
  if (notes.length === 0) return null;
  return (
    <ul className={classes.notes} aria-label="Notes">
      {notes.map((note) => (
        <li key={note.note_id} className={classes.note}>
          <Group justify="space-between" gap="xs" align="start" wrap="nowrap">
            <Text size="sm" c="dimmed">
              <Text span fw={600} c="var(--mantine-color-text)">
                {note.by}
              </Text>{" "}
              <Time value={note.at} />
            </Text>
            <DeleteButton note={note} reason={reason} onDelete={() => onRemove(note.note_id)} />
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
    <ReasonButton
      variant={asked ? "filled" : "subtle"}
      color={asked ? "red" : "gray"}
      c={asked ? undefined : "dimmed"}
      size="compact-xs"
      flex="none"
      reason={reason}
      aria-label={asked ? `Really delete the note by ${note.by}` : `Delete the note by ${note.by}`}
      onBlur={() => setAsked(false)}
      onClick={() => (asked ? onDelete() : setAsked(true))}
    >
      {asked ? "Really delete" : "Delete"}
    </ReasonButton>
  );
}
