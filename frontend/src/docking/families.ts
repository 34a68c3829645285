import type { ActionServer, LiveGoal, Verb } from "@dock-gateway/client";
import { whyForbidden } from "../api/session";
import { NOT_CONNECTED } from "../fleet/context";

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

type Running = Pick<LiveGoal, "status">;

interface Situation {
  live: boolean;
  stopped: boolean;
  /** The goal that runs. */
  running: Running | null;
  /** A goal was sent and is not answered. */
  sending: boolean;
  server: ActionServer | null;
}

/** Why the robot cannot be asked to dock or undock now, in a sentence; null where it can. */
export function whyNotSend(
  verb: Verb,
  { live, stopped, running, sending, server }: Situation,
): string | null {
  const forbidden = whyForbidden(`POST /${verb}`);
  if (forbidden !== null) return forbidden;
  if (!live) return NOT_CONNECTED;
  if (stopped) return "The robot is stopped. Release the stop first.";
  if (sending) return "A goal was sent. The action server has not answered yet.";
  if (running !== null) return "A goal is running. Cancel it first.";
  if (server?.available === true) return null;
  const name = server === null ? "" : ` ${server.action_name}`;
  return `No server offers the action${name}. Start ${whatToStart(verb, server)}.`;
}
