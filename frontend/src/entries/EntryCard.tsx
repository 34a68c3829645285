import type { ClientError } from "@dock-gateway/client";
import { Group, Paper, Stack, Text } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import type { UseMutationResult } from "@tanstack/react-query";
import { type ReactNode, useId } from "react";
import { RemovalDialog } from "../ui/Dialog";
import { ENTRY_BUTTON, ReasonButton } from "../ui/ReasonButton";
import { Time } from "../ui/Time";
import classes from "./EntryCard.module.css";

interface EntryCardProps<Entry> {
  entry: Entry;
  /** What it does, line by line. */
  words: readonly string[];
  /** What it is switched with. */
  control: ReactNode;
  /** Buttons before *Edit* and *Remove*. */
  buttons?: ReactNode;
  /** Why it cannot be changed now; null where it can. */
  reason: string | null;
  onEdit: () => void;
  remove: UseMutationResult<unknown, ClientError, Entry>;
  /** What is lost with it. */
  removal: string;
  children: ReactNode;
}

/** An entry of a list that people keep: what it does, what changes it, and below that what came of it. */
export function EntryCard<Entry extends { name: string; changed_by: string | null; changed_at: string }>(
  props: EntryCardProps<Entry>,
) {
  const { entry, words, control, buttons, reason, onEdit, remove, removal, children } = props;
  const [removing, dialog] = useDisclosure(false);
  const titleId = useId();
  return (
    <Paper
      component="li"
      withBorder
      radius="md"
      p={{ base: "md", sm: "lg" }}
      className={classes.entry}
      aria-labelledby={titleId}
    >
      <div className={classes.head}>
        <Stack gap={2} className={classes.words}>
          <Text fw={600} id={titleId}>
            {entry.name}
          </Text>
          {words.map((line) => (
            <Text size="sm" key={line}>
              {line}
            </Text>
          ))}
          <Text size="sm" c="dimmed">
            Changed {entry.changed_by !== null && `by ${entry.changed_by}, `}
            <Time value={entry.changed_at} />
          </Text>
        </Stack>
        <Stack gap="xs" className={classes.commands}>
          {control}
          <Group gap="xs" className={classes.buttons ?? ""}>
            {buttons}
            <ReasonButton
              {...ENTRY_BUTTON}
              reason={reason}
              aria-label={`Edit ${entry.name}`}
              onClick={onEdit}
            >
              Edit
            </ReasonButton>
            <ReasonButton
              {...ENTRY_BUTTON}
              reason={reason}
              aria-label={`Remove ${entry.name}`}
              onClick={dialog.open}
            >
              Remove
            </ReasonButton>
          </Group>
        </Stack>
      </div>
      {children}
      <RemovalDialog
        title={`Remove ${entry.name}?`}
        opened={removing}
        onClose={dialog.close}
        remove={remove}
        onRemove={() => remove.mutate(entry)}
      >
        <Text size="sm">{removal}</Text>
      </RemovalDialog>
    </Paper>
  );
}
