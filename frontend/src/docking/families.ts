import type { ActionServer, Verb } from "../api/types";

/** Who defines the type of a docking action, and what serves it. */
interface Family {
  name: string;
  /** What to start where no server is there. */
  start: Record<Verb, string>;
}

const OURS: Family = {
  name: "dock-gateway",
  start: { dock: "connect_to_charging_dock_server or docking_server", undock: "docking_server" },
};

const FAMILIES: Record<string, Family> = {
  nav2_msgs: { name: "nav2", start: { dock: "nav2's docking_server", undock: "nav2's docking_server" } },
  irobot_create_msgs: { name: "Create 3", start: { dock: "the robot's base", undock: "the robot's base" } },
  action_tutorials_interfaces: OURS,
};

function familyOf(server: ActionServer): Family | null {
  return FAMILIES[server.action_type.split("/")[0] ?? ""] ?? null;
}

/** Whether its goals say how the battery is to be. Other servers dock until it charges, or until the robot is docked. */
export function takesBatteryGoal(server: ActionServer | null): boolean {
  return server === null || familyOf(server) === OURS;
}

/** Whose docking server a robot has, where it is not ours: `nav2`; else the type. */
export function foreignName(server: ActionServer): string | null {
  const family = familyOf(server);
  return family === OURS ? null : (family?.name ?? server.action_type);
}

/** What to start, so that a robot can dock. */
export function whatToStart(verb: Verb, server: ActionServer | null): string {
  return ((server && familyOf(server)) ?? OURS).start[verb];
}
