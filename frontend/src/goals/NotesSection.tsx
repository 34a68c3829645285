import { Skeleton, Stack } from "@mantine/core";
import { useWhyNot } from "../fleet/useWhyNot";
import { CommandErrorAlert } from "../ui/CommandErrorAlert";
import { Section } from "../ui/Section";
import { Trouble } from "../ui/Trouble";
import { NoteForm } from "./NoteForm";
import { NoteList } from "./NoteList";
import { TagsField } from "./TagsField";
import { useNotes } from "./useNotes";

/** What people say about a goal: its tags, and notes with their authors. */
export function NotesSection({ goalId }: { goalId: string }) {
  const { notes, error, refetch, change } = useNotes(goalId);
  const reason =
    useWhyNot("POST /goals/{goal_id}/notes") ?? (change.isPending ? "The last change is being saved." : null);
  return (
    <Section title="Notes">
      <Trouble what="The notes could not be loaded" error={error} onRetry={() => void refetch()} />
      {notes === null ? (
        error === null && <Skeleton height={110} />
      ) : (
        <Stack gap="sm">
          <TagsField
            tags={notes.tags}
            reason={reason}
            onTags={(tags) => change.mutate((api) => api.setTags(tags))}
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
      <CommandErrorAlert command="Saving" error={change.error} onClose={change.reset} />
    </Section>
  );
}
