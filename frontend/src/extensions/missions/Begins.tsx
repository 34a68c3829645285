import { Text } from "@mantine/core";
import { useFleetPart, useNaming } from "../../fleet/context";
import { useOpenMissions } from "./openMissions";
import { queuesOf } from "./queue";
import type { Taker } from "./TakerField";

/** When a new mission begins. */
export function Begins({ robot, group }: Taker) {
  return (
    <Text size="sm" role="status">
      {group === null ? <ForRobot robot={robot} /> : <ForGroup group={group} />}
    </Text>
  );
}

function ForRobot({ robot }: { robot: string }) {
  const name = useNaming().nameOf(robot);
  const { data: missions = [] } = useOpenMissions();
  const stopped = useFleetPart("robots", (robots) => robots.get(robot)?.stop.latched === true);
  if (stopped)
    return `${name} is stopped: the mission is held until the stop is released and someone continues it.`;
  const queue = queuesOf(missions).find((each) => each.robot === robot);
  const before = queue === undefined ? 0 : queue.next.length + (queue.active === null ? 0 : 1);
  if (before === 0) return `${name} begins at once. Check that the area is clear.`;
  return `${name} has ${before === 1 ? "another mission" : `${before} other missions`}: this one waits for its turn.`;
}

function ForGroup({ group }: { group: string }) {
  const naming = useNaming();
  const names = naming.robotsIn(group).map((robot) => naming.nameOf(robot));
  if (names.length === 0)
    return `No robot is in ${group}: the mission waits until one is. A robot's page has its groups.`;
  const robots = names.length === 1 ? names[0] : `One of ${names.join(", ")}`;
  return `${robots} begins as soon as it is free and has enough charge. Check that the area is clear.`;
}
