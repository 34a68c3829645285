import type { ClientError } from "@dock-gateway/client";
import { Alert, Button, List, Text } from "@mantine/core";
import { adviceFor, titleOf } from "../api/errors";
import { lowerFirst, sentence } from "./text";

interface CommandErrorAlertProps {
  /** What was tried, as in "Dock did not work". */
  command: string;
  error: ClientError | null;
  onClose: () => void;
}

/** What happened to a command that did not work, with its code and what to do. */
export function CommandErrorAlert({ command, error, onClose }: CommandErrorAlertProps) {
  if (error === null) return null;
  return (
    <Alert
      color="red"
      title={`${command} did not work: ${lowerFirst(titleOf(error))}`}
      withCloseButton
      closeButtonLabel="Dismiss the error"
      onClose={onClose}
    >
      <ErrorWords error={error} />
    </Alert>
  );
}

/** What an error says of itself: what happened, in which fields, what to do about it, and its code. */
function ErrorWords({ error }: { error: ClientError }) {
  const advice = adviceFor(error.code);
  return (
    <>
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
      {advice !== null && (
        <Text size="sm" mt={4}>
          {advice}
        </Text>
      )}
      <Text size="sm" mt={4}>
        Code: {error.code}
      </Text>
    </>
  );
}

interface TroubleProps {
  /** What did not work, in a few words. */
  what: string;
  error: ClientError | null;
  onRetry: () => void;
}

/** Why something is not shown, what to do about it, and a button to try once more. */
export function Trouble({ what, error, onRetry }: TroubleProps) {
  if (error === null) return null;
  return (
    <Alert color="red" title={`${what}: ${titleOf(error).toLowerCase()}`}>
      <ErrorWords error={error} />
      <Button variant="default" size="compact-sm" mt="xs" onClick={onRetry}>
        Try again
      </Button>
    </Alert>
  );
}
