import type { Goal, GoalStatus } from "../api/types";
import { isTerminal } from "../store/goals";

export const STATUS_COLORS: Record<GoalStatus, string> = {
  pending: "gray.7",
  accepted: "blue",
  executing: "blue",
  canceling: "orange",
  succeeded: "green",
  canceled: "gray.7",
  aborted: "red",
  rejected: "red",
  lost: "red",
};

const MEANINGS: Record<GoalStatus, string> = {
  pending: "Sent; the action server has not answered yet.",
  accepted: "The action server accepted the goal and will start it.",
  executing: "The action server is working on the goal until the battery says that it is charging.",
  canceling: "The cancellation was accepted; the robot is being stopped.",
  succeeded: "The robot is on the dock.",
  canceled: "Canceled as asked.",
  aborted: "The action server gave up on the goal.",
  rejected: "The action server did not accept the goal.",
  lost: "The action server went away while the goal ran.",
};

/** What the status means, in a sentence. */
export function meaning(goal: Goal): string {
  if (goal.stalled && !isTerminal(goal.status)) {
    return "Stalled: the action server is silent and does not answer.";
  }
  return MEANINGS[goal.status];
}

const LOST =
  "Look at the robot: where it is now is not known here. Start its action server again; if that still knows the goal, the outcome appears here.";
const STALLED =
  "It may come back; otherwise the goal is called lost in some seconds. Press Stop to be on the safe side.";

const ADVICE: Record<string, string> = {
  action_server_timeout: "Look at the action server's log; it may be frozen.",
  battery_lost: "Check the battery driver, or publish a battery state from this page, then dock again.",
  dock_busy: "Wait for the running goal to end, or cancel it first.",
  failed_to_control: "The server's controller is broken; its log says more.",
  preempted: "A newer goal took its place: see Recent goals.",
  shutting_down: "Start the action server again, then dock again.",
  timeout: "Check the robot's way to the dock, or raise the server's goal_timeout.",
};

/** What can be done about a goal that does not go as it should. */
export function advice(goal: Goal): string | null {
  if (goal.status === "lost") return LOST;
  if (goal.error !== null) return ADVICE[goal.error.code] ?? null;
  return goal.stalled ? STALLED : null;
}

const SHORT: Record<string, string> = {
  action_server_lost: "Action server went away",
  action_server_timeout: "Action server did not answer",
  battery_lost: "Battery fell silent",
  dock_busy: "Dock was busy",
  failed_to_control: "Controller failed",
  goal_aborted: "No reason given",
  preempted: "A newer goal took over",
  shutting_down: "Action server shut down",
  timeout: "Took too long",
};

/** A few words for a table; the details say more. */
export function outcome(goal: Goal): string {
  if (goal.error !== null) return SHORT[goal.error.code] ?? goal.error.detail;
  if (goal.status === "succeeded") return "On the dock";
  return goal.stalled ? "Server is silent" : "–";
}

/** The goal to show: the newest that runs, else the one that ended last. */
export function currentGoal(newestFirst: readonly Goal[]): Goal | null {
  const running = newestFirst.find((goal) => !isTerminal(goal.status));
  if (running !== undefined) return running;
  return newestFirst.reduce<Goal | null>(
    (last, goal) => (last === null || endOf(goal) > endOf(last) ? goal : last),
    null,
  );
}

function endOf(goal: Goal): number {
  return Date.parse(goal.finished_at ?? goal.updated_at);
}
