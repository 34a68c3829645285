import type { Verb } from "../api/client";
import type { ActionServer } from "../api/types";
import type { GoalCourse } from "../store/goals";

const NOT_CONNECTED = "Dock, Undock and Cancel need the gateway, which is not connected.";

const SERVERS: Record<Verb, string> = {
  dock: "connect_to_charging_dock_server or docking_server",
  undock: "docking_server",
};

export interface Situation {
  live: boolean;
  stopped: boolean;
  /** The goal that runs. */
  running: GoalCourse | null;
  /** A goal was sent and is not answered. */
  sending: boolean;
  server: ActionServer | null;
}

/** Why the robot cannot be asked to dock or undock now, in a sentence; null where it can. */
export function whyNotSend(
  verb: Verb,
  { live, stopped, running, sending, server }: Situation,
): string | null {
  if (!live) return NOT_CONNECTED;
  if (stopped) return "Dock and Undock: the robot is stopped; release the stop first.";
  if (sending) return "Sending the goal; waiting for the action server's answer.";
  if (running !== null) return "Dock and Undock: a goal is running; cancel it first.";
  if (server?.available === true) return null;
  const name = server === null ? "" : ` ${server.action_name}`;
  return `${verb === "dock" ? "Dock" : "Undock"}: nobody offers the action${name}. Start ${SERVERS[verb]}.`;
}

/** Why nothing can be canceled now. */
export function whyNotCancel(live: boolean, running: GoalCourse | null, pending: boolean): string | null {
  if (!live) return NOT_CONNECTED;
  if (running === null) return "Cancel: no goal is running.";
  if (pending || running.status === "canceling") return "Cancel: the goal is being canceled.";
  if (running.status === "pending") return "Cancel: the action server has not answered yet.";
  return null;
}
