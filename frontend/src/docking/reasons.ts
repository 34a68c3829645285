import { whyForbidden } from "../api/permissions";
import type { ActionServer, Goal, Verb } from "../api/types";
import { NOT_CONNECTED } from "../fleet/context";
import { whatToStart } from "./families";

type Running = Pick<Goal, "status">;

export interface Situation {
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
