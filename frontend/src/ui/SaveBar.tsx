import { Button, Group } from "@mantine/core";
import type { CommandError } from "../api/errors";
import { CommandErrorAlert } from "./CommandErrorAlert";

interface SaveBarProps {
  save: { error: CommandError | null; reset: () => void; isPending: boolean };
  onCancel: () => void;
  verb?: string;
  /** What was tried, as in "Saving did not work". */
  command?: string;
}

/** The end of a form in a dialog: what went wrong, *Cancel* and *Save*. */
export function SaveBar({ save, onCancel, verb = "Save", command = "Saving" }: SaveBarProps) {
  return (
    <>
      <CommandErrorAlert command={command} error={save.error} onClose={save.reset} />
      <Group justify="flex-end" gap="sm">
        <Button variant="default" onClick={onCancel}>
          Cancel
        </Button>
        <Button type="submit" loading={save.isPending}>
          {verb}
        </Button>
      </Group>
    </>
  );
}
