import type { ClientError } from "@dock-gateway/client";
import { Button, CloseButton, Group, Modal, Stack, Text, Title } from "@mantine/core";
import type { UseMutationResult } from "@tanstack/react-query";
import { type ReactNode, useId } from "react";
import { CommandErrorAlert } from "./errors";

interface DialogProps {
  title: string;
  opened: boolean;
  onClose: () => void;
  /** For one with more than a few fields. */
  size?: "xl";
  children: ReactNode;
}

/** A dialog below the header, so that Stop stays in reach. Its title is not a second header of the page. */
export function Dialog({ title, opened, onClose, size, children }: DialogProps) {
  return (
    <Modal.Root
      opened={opened}
      onClose={onClose}
      size={size}
      zIndex={250}
      yOffset="calc(var(--header-height) + 1rem)"
    >
      <Modal.Overlay />
      {/* While it fades out, a second press would send its command again. */}
      <Modal.Content aria-label={title} inert={!opened}>
        <Modal.Body pt="md">
          <Group justify="space-between" mb="sm" wrap="nowrap">
            <Title order={2} size="h4">
              {title}
            </Title>
            <CloseButton aria-label="Close" onClick={onClose} />
          </Group>
          {children}
        </Modal.Body>
      </Modal.Content>
    </Modal.Root>
  );
}

interface RemovalDialogProps {
  title: string;
  opened: boolean;
  onClose: () => void;
  remove: Pick<UseMutationResult<unknown, ClientError, unknown>, "error" | "reset" | "isPending">;
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

interface QuestionBarProps {
  /** The button that leaves things as they are. */
  keep: string;
  onKeep: () => void;
  go: string;
  onGo: () => void;
  /** Why it cannot be done any more; null where it can. It is said above the buttons. */
  reason?: string | null;
}

/** The end of a question in a dialog: what leaves things as they are, which has the focus, and what does it. */
export function QuestionBar({ keep, onKeep, go, onGo, reason }: QuestionBarProps) {
  const reasonId = useId();
  const disabled = reason !== undefined && reason !== null;
  return (
    <>
      {reason !== undefined && (
        <Text size="sm" c="dimmed" id={reasonId} role="status">
          {reason}
        </Text>
      )}
      <Group justify="flex-end" gap="sm">
        <Button variant="default" onClick={onKeep} data-autofocus>
          {keep}
        </Button>
        <Button
          disabled={disabled}
          aria-describedby={reason === undefined ? undefined : reasonId}
          onClick={onGo}
        >
          {go}
        </Button>
      </Group>
    </>
  );
}

interface SaveBarProps {
  save: { error: ClientError | null; reset: () => void; isPending: boolean };
  onCancel: () => void;
  verb?: string;
  /** What was tried, as in "Saving did not work". */
  command?: string;
  /** Says what went wrong in the error's place. */
  trouble?: ReactNode;
}

/** The end of a form in a dialog: what went wrong, *Cancel* and *Save*. */
export function SaveBar({ save, onCancel, verb = "Save", command = "Saving", trouble }: SaveBarProps) {
  return (
    <>
      {trouble || <CommandErrorAlert command={command} error={save.error} onClose={save.reset} />}
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
