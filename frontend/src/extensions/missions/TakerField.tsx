import { NativeSelect } from "@mantine/core";
import { useFleetTopic, useNaming } from "../../fleet/context";
import { namesThere } from "../../fleet/words";

/** Who takes a mission. */
export interface Taker {
  /** Its namespace. */
  robot: string;
  /** Any robot of this group takes it; null for the robot. */
  group: string | null;
}

const ROBOT = "robot ";
const GROUP = "group ";

/** Chooses the robot, or a group of which any robot takes the mission; nothing where there is only one robot. */
export function TakerField({ robot, group, onTaker }: Taker & { onTaker: (taker: Taker) => void }) {
  const naming = useNaming();
  const robots = useFleetTopic("robots");
  const there = namesThere(robots);
  const names = naming.inOrder([...there, robot]);
  const groups = [...new Set([...naming.groups(), ...(group === null ? [] : [group])])];
  if (names.length === 1 && groups.length === 0) return null;
  const choices = names.map((name) => ({ value: ROBOT + name, label: naming.fullNameOf(name) }));
  return (
    <NativeSelect
      label={groups.length === 0 ? "Robot" : "For"}
      description={group === null ? "It takes the steps." : "The free one with the most charge takes them."}
      value={group === null ? ROBOT + robot : GROUP + group}
      onChange={({ currentTarget: { value } }) =>
        onTaker(
          value.startsWith(GROUP)
            ? { robot, group: value.slice(GROUP.length) }
            : { robot: value.slice(ROBOT.length), group: null },
        )
      }
      data={
        groups.length === 0
          ? choices
          : [
              { group: "A robot", items: choices },
              {
                group: "Any robot of a group",
                items: groups.map((name) => ({ value: GROUP + name, label: `Any of ${name}` })),
              },
            ]
      }
    />
  );
}

/** The robot whose docks and actions are offered: of a group, the first one. */
export function useExampleRobot({ robot, group }: Taker): string {
  const naming = useNaming();
  if (group === null) return robot;
  return naming.inOrder(naming.robotsIn(group))[0] ?? robot;
}
