import type { Verb } from "../api/client";
import type { AnyGoal, GoalStatus } from "../api/types";
import { type GoalCourse, isTerminal } from "../store/goals";
import { stageName, stageWords } from "./stages";

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

const MEANINGS: Record<Exclude<GoalStatus, "executing" | "succeeded">, string> = {
  pending: "Sent; the action server has not answered yet.",
  accepted: "The action server accepted the goal and will start it.",
  canceling: "The cancellation was accepted; the action server is stopping what it does.",
  canceled: "Canceled as asked.",
  aborted: "The action server aborted the goal.",
  rejected: "The action server did not accept the goal.",
  lost: "The action server went away while the goal ran.",
};

const EXECUTING: Record<Verb | "other", string> = {
  other: "The action server is working on the goal.",
  dock: "The action server is working on the goal until the battery says that it is charging.",
  undock: "The action server backs the robot out of the dock.",
};

const SUCCEEDED: Record<Verb | "other", string> = {
  other: "The action server did what was asked.",
  dock: "The robot is on the dock.",
  undock: "The robot is off the dock.",
};

const VERBS: Record<string, Verb> = {
  "action_tutorials_interfaces/action/ConnectToChargingDock": "dock",
  "action_tutorials_interfaces/action/DisconnectFromChargingDock": "undock",
};

/** Which of the docking actions a goal is on; null where it is on any other. */
export function dockingVerb(goal: Pick<AnyGoal, "action_type">): Verb | null {
  return VERBS[goal.action_type] ?? null;
}

/** What status and stage mean, in a sentence; `verb` is null for a goal on any other action. */
export function meaning(goal: Pick<AnyGoal, "status" | "stage" | "stalled">, verb: Verb | null): string {
  if (goal.stalled && !isTerminal(goal.status)) {
    return "Stalled: the action server is silent and does not answer.";
  }
  if (goal.status === "succeeded") return SUCCEEDED[verb ?? "other"];
  if (goal.status === "executing") return stageWords(goal.stage) ?? EXECUTING[verb ?? "other"];
  return MEANINGS[goal.status];
}

const LOST =
  "Look at the robot: where it is now is not known here. Start its action server again; if that still knows the goal, the outcome appears here.";
const STALLED = "If it stays silent, the goal is marked lost in a few seconds. Press Stop to be safe.";

const ADVICE: Record<string, string> = {
  action_server_timeout: "Look at the action server's log; it may be frozen.",
  battery_lost: "Check the battery driver, or publish a battery state from this page, then dock again.",
  blocked: "Look at the robot: something is in its way, a wheel is stuck, or its motors are off.",
  dock_busy: "Wait for the running goal to end, or cancel it first.",
  failed_to_charge:
    "The robot touches the dock, but no current comes: look at the dock's power, and clean its contacts.",
  failed_to_control:
    "Look at what is between robot and dock, then dock again; where it happens again, the controller's log says more.",
  failed_to_detect_dock:
    "Bring the robot nearer and turn it to the dock, so that its camera sees the marker.",
  failed_to_stage: "Clear the way to the staging pose in front of the dock, or bring the robot nearer.",
  failed_to_undock: "Look at the robot: it may be held by the dock, or something stands behind it.",
  infrared_lost:
    "See that nothing stands before the dock's beacon and the robot's receivers, then dock again.",
  lost_marker: "See that nothing stands before the marker and that it is well lit, then dock again.",
  odometry_lost: "Check the robot's base driver: nothing comes on odom.",
  preempted: "A newer goal took its place: see the list of goals.",
  pushed_off: "Somebody or something moved the robot off its dock: dock again.",
  shutting_down: "Start the action server again, then dock again.",
  stop_latched: "Release the stop, then send the goal again.",
  timeout: "Check the robot's way to the dock, or raise the server's goal_timeout.",
};

/** What can be done about a goal that does not go as it should. */
export function advice(goal: Pick<AnyGoal, "status" | "error" | "stalled">): string | null {
  if (goal.status === "lost") return LOST;
  if (goal.error !== null) return ADVICE[goal.error.code] ?? null;
  return goal.stalled ? STALLED : null;
}

const SHORT: Record<string, string> = {
  action_server_lost: "Action server went away",
  goal_unconfirmed: "Never confirmed by the action server",
  action_server_timeout: "Action server did not answer",
  battery_lost: "Battery fell silent",
  blocked: "Robot was blocked",
  dock_busy: "Dock was busy",
  failed_to_charge: "No charge on the dock",
  failed_to_control: "Dock was not reached",
  failed_to_detect_dock: "Dock was not found",
  failed_to_stage: "Staging pose was not reached",
  failed_to_undock: "Did not get off the dock",
  goal_aborted: "No reason given",
  result_too_large: "Result too large to show",
  infrared_lost: "Beacon was lost",
  lost_marker: "Marker was lost",
  odometry_lost: "Odometry fell silent",
  preempted: "A newer goal took over",
  pushed_off: "Pushed off the dock",
  shutting_down: "Action server shut down",
  stop_latched: "A stop was latched",
  timeout: "Took too long",
};

const REACHED: Record<Verb, string> = { dock: "On the dock", undock: "Off the dock" };

/** A few words for a table; the goal's page says more. */
export function outcome(
  goal: Pick<AnyGoal, "error" | "stalled" | "status" | "stage">,
  verb: Verb | null,
): string {
  if (goal.error !== null) return SHORT[goal.error.code] ?? goal.error.detail;
  if (goal.status === "succeeded" && verb !== null) return REACHED[verb];
  if (goal.stalled) return "Server is silent";
  return goal.stage === null || isTerminal(goal.status) ? "–" : stageName(goal.stage);
}

/** The goal to show: the newest that runs, else the one that ended last. */
export function currentGoal(newestFirst: readonly GoalCourse[]): GoalCourse | null {
  const running = newestFirst.find((goal) => !isTerminal(goal.status));
  if (running !== undefined) return running;
  return newestFirst.reduce<GoalCourse | null>(
    (last, goal) => (last === null || endOf(goal) > endOf(last) ? goal : last),
    null,
  );
}

function endOf(goal: GoalCourse): number {
  return Date.parse(goal.finished_at ?? goal.updated_at);
}
