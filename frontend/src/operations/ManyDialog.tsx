import { Button, Group, Stack, Text } from "@mantine/core";
import { useMemo } from "react";
import { useFleetLive, useFleetTopic, useNaming } from "../fleet/context";
import { Dialog } from "../ui/Dialog";
import { ReasonButton } from "../ui/ReasonButton";
import { divide, OPERATION_NAMES, type Operation } from "./operation";
import classes from "./operations.module.css";
import { RefusalList } from "./results";

const WHAT_HAPPENS: Record<Operation, string> = {
  dock: "They drive to their docks by themselves. Check first that their area is clear.",
  undock: "They back out of their docks by themselves. Check first that the area behind them is clear.",
  cancel: "Their goals are canceled, and they stand still.",
  stop: "",
};

interface ManyDialogProps {
  operation: Operation;
  /** The robots' names. */
  names: readonly string[];
  opened: boolean;
  onGo: (able: readonly string[]) => void;
  onClose: () => void;
}

/** Asks before something is done to several robots: names them, and says which ones it cannot be done to. */
export function ManyDialog({ operation, names, opened, onGo, onClose }: ManyDialogProps) {
  const robots = useFleetTopic("robots");
  const live = useFleetLive();
  const naming = useNaming();
  const { able, unable } = useMemo(() => {
    const known = names.flatMap((name) => robots.get(name) ?? []);
    const { able, unable } = divide(operation, known, live);
    const gone = names.filter((name) => !robots.has(name));
    return {
      able,
      unable: [...unable, ...gone.map((name) => ({ name, reason: "It has left the ROS graph." }))],
    };
  }, [operation, names, robots, live]);
  const name = OPERATION_NAMES[operation];
  const count = able.length === 1 ? "1 robot" : `${able.length} robots`;
  return (
    <Dialog opened={opened} onClose={onClose} title={`${name} ${count}?`}>
      <Stack gap="md">
        {able.length > 0 && (
          <>
            <Text fw={600} className={classes.names ?? ""} tabIndex={0}>
              {able.map((robot) => naming.fullNameOf(robot.name)).join(", ")}
            </Text>
            <Text size="sm">{WHAT_HAPPENS[operation]}</Text>
          </>
        )}
        {unable.length > 0 && (
          <section aria-label="Left out">
            <Text size="sm">
              Left out: {unable.length} of {names.length} robots
            </Text>
            <Text component="div" size="sm" className={classes.names ?? ""} tabIndex={0}>
              <RefusalList naming={naming} refused={unable} />
            </Text>
          </section>
        )}
        <Group justify="flex-end" gap="sm">
          <Button variant="default" onClick={onClose} data-autofocus>
            {operation === "cancel" ? "Let them go on" : "Leave them there"}
          </Button>
          <ReasonButton
            reason={able.length === 0 ? "None of the robots can do this now." : null}
            onClick={() => onGo(able.map((robot) => robot.name))}
          >
            {name} {count}
          </ReasonButton>
        </Group>
      </Stack>
    </Dialog>
  );
}
