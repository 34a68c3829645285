import { whyForbidden } from "../api/permissions";
import type { Goal } from "../api/types";
import { NOT_CONNECTED } from "../fleet/context";
import { isFinal } from "../store/goals";

/**
 * Why a goal cannot be canceled now, in a sentence; null where it can. One that is lost can be: its server may come back.
 *
 * @param goal Null where none is running.
 * @param canceling Whether the request is under way.
 */
export function whyNotCancel(
  live: boolean,
  goal: Pick<Goal, "status"> | null,
  canceling: boolean,
): string | null {
  const forbidden = whyForbidden("POST /goals/{goal_id}/cancel");
  if (forbidden !== null) return forbidden;
  if (goal !== null && isFinal(goal.status)) return "The goal has ended.";
  if (!live) return NOT_CONNECTED;
  if (goal === null) return "No goal is running.";
  if (canceling || goal.status === "canceling") return "The goal is being canceled.";
  if (goal.status === "pending") return "The action server has not answered yet.";
  return null;
}
