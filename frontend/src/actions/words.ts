import { goalsPath } from "../api/actions";
import { whyForbidden } from "../api/permissions";
import type { ActionInfo } from "../api/types";
import { NOT_CONNECTED } from "../fleet/context";
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
  if (!live) return NOT_CONNECTED;
  if (stopped) return "The robot is stopped. Release the stop first.";
  if (sending) return "A goal was sent. The action server has not answered yet.";
  if (action?.available !== true) return "No action server for this action. Start it first.";
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
