import { goalsPath } from "../api/actions";
import { whyForbidden } from "../api/permissions";
import type { ActionInfo, AnyGoal } from "../api/types";
import { isUnder } from "../fleet/names";
import type { HeldStop } from "../stop/held";

interface Circumstances {
  live: boolean;
  action: ActionInfo | null;
  stopped: boolean;
  sending: boolean;
}

/** Why no goal can be sent; null where one can. */
export function whyNotSend({ live, action, stopped, sending }: Circumstances): string | null {
  const forbidden = whyForbidden("POST /actions/{name}/goals");
  if (forbidden !== null) return forbidden;
  if (!live) return "Sending a goal needs the gateway, which is not connected.";
  if (stopped) return "The robot is stopped: release the stop first.";
  if (sending) return "Sending the goal; waiting for the action server's answer.";
  if (action?.available !== true) return "Nobody offers this action now: start its action server.";
  return null;
}

/** Why a goal cannot be canceled; null where it can. */
export function whyNotCancel(live: boolean, goal: AnyGoal, canceling: boolean): string | null {
  const forbidden = whyForbidden("POST /goals/{goal_id}/cancel");
  if (forbidden !== null) return forbidden;
  if (!live) return "Canceling needs the gateway, which is not connected.";
  if (canceling || goal.status === "canceling") return "The goal is being canceled.";
  if (goal.status === "pending") return "The action server has not answered yet.";
  return null;
}

/** Whether one of these stops holds an action. */
export function isHeld(action: string, stops: readonly HeldStop[]): boolean {
  return stops.some(({ robot, holds }) => [robot, ...holds].some((held) => isUnder(action, held)));
}

/** The command line that sends a goal, for any POSIX shell. */
export function sendLine(origin: string, action: string, body: string): string {
  return `curl -sX POST ${origin}${goalsPath(action)} -H 'Content-Type: application/json' -d ${quoted(body)}`;
}

/** A word of a shell that stands for this text, whatever is in it. */
export function quoted(text: string): string {
  return `'${text.replaceAll("'", "'\\''")}'`;
}
