import type { Verb } from "@dock-gateway/client";
import { Stack, Text } from "@mantine/core";
import { useLocalStorage } from "@mantine/hooks";
import { useTopicPart } from "../store/context";
import { Dialog, QuestionBar } from "../ui/Dialog";

interface MoveDialogProps {
  opened: boolean;
  /** What the robot is about to do. */
  verb: Verb;
  /** The robot's name, where there is more than one. */
  robot: string | null;
  /** The name of the dock that it drives to, where there are several. */
  dock?: string | undefined;
  /** Why it cannot be done any more; null where it can. */
  reason: string | null;
  onMove: () => void;
  onClose: () => void;
}

const NAMES: Record<Verb, string> = { dock: "Dock", undock: "Undock" };

const WHAT_HAPPENS: Record<Verb, (dock: string) => string> = {
  dock: (dock) => `It drives to ${dock} by itself. Check first that the area is clear.`,
  undock: () => "It leaves its dock by itself. Check first that the area in front of the dock is clear.",
};

/** Asks before the robot moves. Stop stays within reach, and so does the choice to leave the robot where it is. */
export function MoveDialog({ opened, verb, robot, dock, reason, onMove, onClose }: MoveDialogProps) {
  return (
    <Dialog opened={opened} onClose={onClose} title={`${NAMES[verb]} ${robot ?? "the robot"}?`}>
      <Stack gap="md">
        <Text size="sm">{WHAT_HAPPENS[verb](dock === undefined ? "its dock" : `the dock ${dock}`)}</Text>
        <QuestionBar
          keep="Leave it where it is"
          onKeep={onClose}
          go={NAMES[verb]}
          onGo={onMove}
          reason={reason}
        />
      </Stack>
    </Dialog>
  );
}

const KEY = "dock-gateway-ask-before-moving";

interface Asking {
  /** Whether a click that makes the robot move is asked about. */
  asks: boolean;
  /** A simulated robot hurts no one: it moves without a question. */
  simulated: boolean;
  change: (asks: boolean) => void;
}

/** Whether this browser asks before a real robot moves. */
export function useAskingWanted() {
  return useLocalStorage({ key: KEY, defaultValue: true, getInitialValueInEffect: false });
}

/** Whether to ask before this robot moves: a real one, until somebody switches that off in this browser. */
export function useAsking(): Asking {
  const simulated = useTopicPart("simulator", (simulator) => simulator !== null);
  const [wanted, change] = useAskingWanted();
  return { asks: wanted && !simulated, simulated, change };
}
