import { Button, Group, Stack, Text } from "@mantine/core";
import { useId } from "react";
import type { Verb } from "../api/types";
import { Dialog } from "../ui/Dialog";

interface MoveDialogProps {
  opened: boolean;
  /** What the robot is about to do. */
  verb: Verb;
  /** The robot's name, where there is more than one. */
  robot: string | null;
  /** Why it cannot be done any more; null where it can. */
  reason: string | null;
  onMove: () => void;
  onClose: () => void;
}

const NAMES: Record<Verb, string> = { dock: "Dock", undock: "Undock" };

const WHAT_HAPPENS: Record<Verb, string> = {
  dock: "It drives to its dock by itself. Check first that the area is clear.",
  undock: "It backs out of its dock by itself. Check first that the area behind it is clear.",
};

/** Asks before the robot moves. Stop stays within reach, and so does the choice to leave the robot where it is. */
export function MoveDialog({ opened, verb, robot, reason, onMove, onClose }: MoveDialogProps) {
  const reasonId = useId();
  return (
    <Dialog opened={opened} onClose={onClose} title={`${NAMES[verb]} ${robot ?? "the robot"}?`}>
      <Stack gap="md">
        <Text size="sm">{WHAT_HAPPENS[verb]}</Text>
        <Text size="sm" c="dimmed" id={reasonId} role="status">
          {reason}
        </Text>
        <Group justify="flex-end" gap="sm">
          <Button variant="default" onClick={onClose} data-autofocus>
            Leave it where it is
          </Button>
          <Button disabled={reason !== null} aria-describedby={reasonId} onClick={onMove}>
            {NAMES[verb]}
          </Button>
        </Group>
      </Stack>
    </Dialog>
  );
}
