import { Text } from "@mantine/core";
import type { UseMutationResult } from "@tanstack/react-query";
import type { Token } from "../api/access";
import type { CommandError } from "../api/errors";
import { RemovalDialog } from "../ui/RemovalDialog";
import { loginName } from "./who";

interface RevokeDialogProps {
  /** Null for none: then it is closed. */
  token: Token | null;
  revoke: UseMutationResult<void, CommandError, string>;
  onClose: () => void;
}

/** Asks before a token is revoked, and says what ends with it. */
export function RevokeDialog({ token, revoke, onClose }: RevokeDialogProps) {
  return (
    <RemovalDialog
      title={`Revoke the token of ${token?.name}?`}
      opened={token !== null}
      onClose={onClose}
      remove={revoke}
      onRemove={() => token !== null && revoke.mutate(token.id, { onSuccess: onClose })}
      verb="Revoke"
    >
      <Text size="sm">
        Requests with it are refused, and the open pages and streams of {token?.name} end: here at once, at
        other gateways within 2 s. Goals that {token?.name} has sent go on. A revoked token cannot be
        restored.
      </Text>
      {token !== null && token.name === loginName() && (
        <Text size="sm" fw={600}>
          You are logged in with this token: this page will ask you to log in.
        </Text>
      )}
    </RemovalDialog>
  );
}
