import { Stack, Text } from "@mantine/core";
import { useFleetPart } from "../fleet/context";
import { defaultRobot } from "../fleet/names";
import { useServices } from "../store/context";
import { Command } from "../ui/Command";

/** How the robot gets a docking server that is in another namespace: the lines to set. */
export function JoinHint() {
  const { robot } = useServices();
  const join = useFleetPart("robots", (robots) => robots.get(robot ?? defaultRobot(robots))?.join ?? null);
  if (join === null) return null;
  return (
    <Stack gap={4} data-testid="join">
      <Text size="sm">
        No docking server is in this robot's namespace, but one without a battery is in another. If it is this
        robot's, set this where the gateway is started, and restart it:
      </Text>
      {join.settings.map((line) => (
        <Command key={line} line={line} what="the setting" />
      ))}
    </Stack>
  );
}
