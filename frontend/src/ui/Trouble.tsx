import { Alert, Button } from "@mantine/core";
import type { CommandError } from "../api/errors";
import { ErrorWords } from "./ErrorWords";

interface TroubleProps {
  /** What did not work, in a few words. */
  what: string;
  error: CommandError | null;
  onRetry: () => void;
}

/** Why something is not shown, what to do about it, and a button to try once more. */
export function Trouble({ what, error, onRetry }: TroubleProps) {
  if (error === null) return null;
  return (
    <Alert color="red" title={`${what}: ${error.title.toLowerCase()}`}>
      <ErrorWords error={error} />
      <Button variant="default" size="compact-sm" mt="xs" onClick={onRetry}>
        Try again
      </Button>
    </Alert>
  );
}
