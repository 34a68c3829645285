import { Button, Group } from "@mantine/core";
import type { CommandError } from "../api/errors";
import { CommandErrorAlert } from "./CommandErrorAlert";

interface SaveBarProps {
  save: { error: CommandError | null; reset: () => void; isPending: boolean };
  onCancel: () => void;
}

/** The end of a form in a dialog: what went wrong, Cancel and Save. */
export function SaveBar({ save, onCancel }: SaveBarProps) {
  return (
    <>
      <CommandErrorAlert command="Saving" error={save.error} onClose={save.reset} />
      <Group justify="flex-end" gap="sm">
        <Button variant="default" onClick={onCancel}>
          Cancel
        </Button>
        <Button type="submit" loading={save.isPending}>
          Save
        </Button>
      </Group>
    </>
  );
}
