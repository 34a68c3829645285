import type { ActionInfo, AnyGoal, GoalStatus } from "../api/types";
import { type HeldStop, isUnder } from "../stop/held";
import { isTerminal } from "../store/goals";

const MEANINGS: Record<GoalStatus, string> = {
  pending: "Sent; the action server has not answered yet.",
  accepted: "The action server accepted the goal and will start it.",
  executing: "The action server is working on the goal.",
  canceling: "The cancellation was accepted; the action server is ending the goal.",
  succeeded: "The action server has done what was asked.",
  canceled: "Canceled as asked.",
  aborted: "The action server aborted the goal.",
  rejected: "The action server did not accept the goal.",
  lost: "The action server went away while the goal ran.",
};

/** What a goal's status means, in a sentence. */
export function meaning(goal: AnyGoal): string {
  if (goal.stalled && !isTerminal(goal.status)) {
    return "Stalled: the action server is silent and does not answer.";
  }
  return MEANINGS[goal.status];
}

interface Circumstances {
  live: boolean;
  action: ActionInfo | null;
  stopped: boolean;
  sending: boolean;
}

/** Why no goal can be sent; null where one can. */
export function whyNotSend({ live, action, stopped, sending }: Circumstances): string | null {
  if (!live) return "Sending a goal needs the gateway, which is not connected.";
  if (stopped) return "The robot is stopped: release the stop first.";
  if (sending) return "Sending the goal; waiting for the action server's answer.";
  if (action?.available !== true) return "Nobody offers this action now: start its action server.";
  return null;
}

/** Why a goal cannot be canceled; null where it can. */
export function whyNotCancel(live: boolean, goal: AnyGoal, canceling: boolean): string | null {
  if (!live) return "Canceling needs the gateway, which is not connected.";
  if (canceling || goal.status === "canceling") return "The goal is being canceled.";
  if (goal.status === "pending") return "Cancel: the action server has not answered yet.";
  return null;
}

/** Whether one of these stops holds an action. */
export function isHeld(action: string, stops: readonly HeldStop[]): boolean {
  return stops.some(({ robot, below }) => [robot, ...below].some((held) => isUnder(action, held)));
}
