import { Alert, List, Text } from "@mantine/core";
import type { CommandError } from "../api/errors";
import { sentence } from "./sentence";

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
      <Text size="sm">{sentence(error.detail)}</Text>
      {error.fields.length > 1 && (
        <List size="sm">
          {error.fields.map((field) => (
            <List.Item key={field.path}>
              {field.path}: {field.detail}
            </List.Item>
          ))}
        </List>
      )}
      {error.advice !== null && (
        <Text size="sm" mt={4}>
          {error.advice}
        </Text>
      )}
      <Text size="sm" mt={4}>
        Code: {error.code}
      </Text>
    </Alert>
  );
}

function lowerFirst(text: string): string {
  return text.charAt(0).toLowerCase() + text.slice(1);
}
