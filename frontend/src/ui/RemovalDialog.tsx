import { Button, Group, Stack } from "@mantine/core";
import type { UseMutationResult } from "@tanstack/react-query";
import type { ReactNode } from "react";
import type { CommandError } from "../api/errors";
import { CommandErrorAlert } from "./CommandErrorAlert";
import { Dialog } from "./Dialog";

interface RemovalDialogProps {
  title: string;
  opened: boolean;
  onClose: () => void;
  remove: UseMutationResult<unknown, CommandError, string>;
  onRemove: () => void;
  verb?: "Remove" | "Revoke";
  /** What is lost. */
  children: ReactNode;
}

/** Asks before something is removed for good. */
export function RemovalDialog(props: RemovalDialogProps) {
  const { title, opened, onClose, remove, onRemove, verb = "Remove", children } = props;
  return (
    <Dialog opened={opened} onClose={onClose} title={title}>
      <Stack gap="md">
        {children}
        <CommandErrorAlert
          command={verb === "Remove" ? "Removing" : "Revoking"}
          error={remove.error}
          onClose={remove.reset}
        />
        <Group justify="flex-end" gap="sm">
          <Button variant="default" onClick={onClose} data-autofocus>
            Keep it
          </Button>
          <Button color="red" loading={remove.isPending} onClick={onRemove}>
            {verb}
          </Button>
        </Group>
      </Stack>
    </Dialog>
  );
}
