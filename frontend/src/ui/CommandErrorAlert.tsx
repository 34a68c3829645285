import { Alert } from "@mantine/core";
import type { CommandError } from "../api/errors";
import { ErrorWords } from "./ErrorWords";
import { lowerFirst } from "./sentence";

interface CommandErrorAlertProps {
  /** What was tried, as in "Dock did not work". */
  command: string;
  error: CommandError | null;
  onClose: () => void;
}

/** What happened to a command that did not work, with its code and what to do. */
export function CommandErrorAlert({ command, error, onClose }: CommandErrorAlertProps) {
  if (error === null) return null;
  return (
    <Alert
      color="red"
      title={`${command} did not work: ${lowerFirst(error.title)}`}
      withCloseButton
      closeButtonLabel="Dismiss the error"
      onClose={onClose}
    >
      <ErrorWords error={error} />
    </Alert>
  );
}
