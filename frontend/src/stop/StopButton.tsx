import { Button, Group, Kbd } from "@mantine/core";
import { useCallback, useEffect, useState } from "react";
import { whoStops } from "../access/who";
import { useFleet, useFleetLive, useFleetPart, useFleetTopic, useNaming } from "../fleet/context";
import { defaultRobot } from "../fleet/names";
import { useServices } from "../store/context";
import { useCommand } from "../ui/requests";
import { useStopping } from "./everywhere";
import { heldStops } from "./held";
import { useStopKeys } from "./keys";
import { announceStop, showRecovered, showStopped } from "./notices";
import classes from "./stop.module.css";

/**
 * Stops every robot, and keeps them stopped. Enabled always: also while disconnected, while a Stop is under way, and in
 * dialogs.
 */
export function StopButton() {
  const { store } = useFleet();
  const live = useFleetLive();
  const stop = useFleetTopic("stop");
  const stopNow = useStopping();
  const [underWay, setUnderWay] = useState(0);
  const press = useCallback(() => {
    setUnderWay((count) => count + 1);
    void stopNow(null).finally(() => setUnderWay((count) => count - 1));
  }, [stopNow]);
  useStopKeys(press);

  useEffect(() => {
    if (!live) return;
    const held = heldStops(stop, store.get("robots"));
    showRecovered(
      held.flatMap(({ holds }) => holds),
      store.get("naming"),
    );
  }, [live, stop, store]);

  return (
    <Group gap="xs" wrap="nowrap">
      <Group gap={4} wrap="nowrap" className={classes.keys ?? ""} aria-hidden="true">
        <Kbd>Esc</Kbd>
        <Kbd>Esc</Kbd>
      </Group>
      <Button
        size="lg"
        color="red"
        className={classes.stop}
        data-stopping={underWay > 0 || undefined}
        aria-keyshortcuts="Control+Shift+X"
        title="Zero velocity at once, every goal is canceled, and none is sent until the stop is released (Esc twice, or Ctrl+Shift+X)"
        onClick={press}
      >
        Stop
      </Button>
    </Group>
  );
}

/**
 * The name of this robot where it can be stopped alone; null where the Stop in the header does just that: for the only
 * robot, and for one in the root namespace, which all others are below.
 */
export function useStoppableAlone(): string | null {
  const { robot } = useServices();
  return useFleetPart("robots", (robots) => {
    const name = robot ?? defaultRobot(robots);
    return robots.size > 1 && name !== "/" ? name : null;
  });
}

/** Stops this robot alone. Enabled always, as Stop in the header is. */
export function RobotStopButton({ robot }: { robot: string }) {
  const { gateway, store } = useServices();
  const naming = useNaming();
  // Callbacks of `mutate` would not be called once another page is shown.
  const { mutate, isPending } = useCommand(() =>
    announceStop(
      () => naming,
      [robot],
      async () => {
        const report = await gateway.stop(whoStops(), [robot]);
        store.setStop(report.stop);
        return report;
      },
      showStopped,
    ),
  );
  return (
    <Button
      size="lg"
      color="red"
      variant="outline"
      data-stopping={isPending || undefined}
      title={`Zero velocity at once, every goal of ${naming.fullNameOf(robot)} is canceled, and none is sent until the stop is released`}
      onClick={() => mutate()}
    >
      Stop {naming.nameOf(robot)}
    </Button>
  );
}
