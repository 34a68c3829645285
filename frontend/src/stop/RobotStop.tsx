import { Button } from "@mantine/core";
import { whoStops } from "../access/who";
import { useFleetPart, useNaming } from "../fleet/context";
import { defaultRobot } from "../fleet/names";
import { useServices } from "../store/context";
import { useCommand } from "../ui/requests";
import { announceStop } from "./notices";

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
        const report = await gateway.stop(whoStops());
        store.setStop(report.stop);
        return report;
      },
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
