import type { Naming } from "./names";

/** All robots, or some by their names and groups. */
export interface RobotChoice {
  all: boolean;
  names: string[];
  groups: string[];
}

export const ALL_ROBOTS: RobotChoice = { all: true, names: [], groups: [] };

/** Whether a robot that is in these groups is one of those. */
export function isCovered(chosen: RobotChoice, robot: string, groups: readonly string[]): boolean {
  return chosen.all || chosen.names.includes(robot) || groups.some((group) => chosen.groups.includes(group));
}

/** `All robots`, `Left forklift, robots in hall 1` */
export function robotsWords(chosen: RobotChoice, naming: Naming): string {
  if (chosen.all) return "All robots";
  const groups = chosen.groups.length === 0 ? [] : [`robots in ${chosen.groups.join(", ")}`];
  const words = [...chosen.names.map((name) => naming.nameOf(name)), ...groups].join(", ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/** What is wrong with a choice; undefined if nothing is. */
export function choiceError({ all, names, groups }: RobotChoice): string | undefined {
  return all || names.length + groups.length > 0 ? undefined : "Choose a robot or a group.";
}

/** The choice as the body of a request. */
export function choiceBody({ all, names, groups }: RobotChoice) {
  return all ? { all: true } : { names, groups };
}
