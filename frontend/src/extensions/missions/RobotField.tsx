import { NativeSelect } from "@mantine/core";
import { useFleetTopic, useNaming } from "../../fleet/context";
import { byName } from "../../fleet/names";
import { isThere } from "../../fleet/words";

/** Chooses the robot; nothing where there is only one. */
export function RobotField({ robot, onRobot }: { robot: string; onRobot: (robot: string) => void }) {
  const naming = useNaming();
  const robots = useFleetTopic("robots");
  const there = [...robots.values()].flatMap((each) => (isThere(each) ? [each.name] : []));
  const names = [...new Set([...there, robot])].sort(byName);
  if (names.length === 1) return null;
  return (
    <NativeSelect
      label="Robot"
      description="It takes the steps."
      value={robot}
      onChange={(event) => onRobot(event.currentTarget.value)}
      data={names.map((name) => ({ value: name, label: naming.fullNameOf(name) }))}
    />
  );
}
