import {
  type GoalStatus,
  type GoalSummary,
  isFinal,
  isTerminal,
  type LiveGoal,
  type Verb,
} from "@dock-gateway/client";
import { adviceFor } from "../api/errors";
import { whyForbidden } from "../api/session";
import { NOT_CONNECTED } from "../fleet/context";
import type { Naming } from "../fleet/names";
import type { GoalCourse } from "../store/goals";
import { lowerFirst, sentence } from "../ui/text";
import { formatDuration } from "../ui/time";
import { stageLabel, stageName, stageWords } from "./stages";

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

const MEANINGS: Record<Exclude<GoalStatus, "executing" | "succeeded" | "aborted" | "lost">, string> = {
  pending: "Sent; the action server has not answered yet.",
  accepted: "The action server accepted the goal and will start it.",
  canceling: "The cancel request was accepted; the action server is ending the goal.",
  canceled: "Canceled on request.",
  rejected: "The action server rejected the goal.",
};

const EXECUTING: Record<Verb | "other", string> = {
  other: "The action server is working on the goal.",
  dock: "Docking until the battery is charging.",
  undock: "Backing out of the dock.",
};

/** What the goal came to: where the robot is now is said beside its name. */
const SUCCEEDED: Record<Verb | "other", string> = {
  other: "The goal succeeded.",
  dock: "The robot reached the dock.",
  undock: "The robot left the dock.",
};

const ABORTED: Record<Verb | "other", string> = {
  other: "The action server aborted the goal",
  dock: "Docking failed",
  undock: "Undocking failed",
};

const LOST: Record<Verb | "other", string> = {
  other: "Lost contact with the action server; the outcome is unknown.",
  dock: "Lost contact during docking; robot state unknown.",
  undock: "Lost contact during undocking; robot state unknown.",
};

/** What the meaning of a goal is made of. */
export type Meant = Pick<LiveGoal, "verb" | "status" | "stage" | "stalled" | "error">;

/** What a goal's status and stage mean, in a sentence. */
export function meaning(goal: Meant): string {
  const { status, error } = goal;
  const verb = goal.verb ?? "other";
  if (goal.stalled && !isTerminal(status)) {
    return verb === "other" ? "The action server is not responding." : "Docking server not responding.";
  }
  if (error?.code === "stopped" && isTerminal(status)) return `${outcome(goal)}.`;
  if (status === "succeeded") return SUCCEEDED[verb];
  if (status === "executing") return stageWords(goal.stage) ?? EXECUTING[verb];
  if (status === "lost") return LOST[verb];
  const why = error === null ? undefined : SHORT[error.code];
  if (status === "aborted") return because(ABORTED[verb], why);
  return status === "canceled" && why !== undefined ? because("Canceled", why) : MEANINGS[status];
}

function because(what: string, why: string | undefined): string {
  return why === undefined ? `${what}.` : `${what}: ${lowerFirst(why)}.`;
}

const FIND_IT =
  "Check where the robot is. Restart its action server; if it still knows the goal, the result appears here.";
const STALLED = "If it stays silent, the goal is marked lost in a few seconds. Press Stop to be safe.";

const ADVICE: Record<string, string> = {
  action_server_timeout: "Look at the action server's log; it may be frozen.",
  action_server_unresponsive: "Look at the action server's log; it may be frozen.",
  battery_lost: "Check the battery driver, or publish a battery state from this page, then dock again.",
  blocked: "Look at the robot: something is in its way, a wheel is stuck, or its motors are off.",
  dock_not_in_db:
    "Name a dock of the docking server's database with dock_id, or set the gateway's default_dock to one.",
  dock_not_valid:
    "Check the docking server's dock plugins. To undock a robot that this server has not docked, send its dock_type.",
  failed_to_dock: "Look at the robot: it may not see the dock, or not stand right on it. Then dock again.",
  dock_busy: "Wait for the running goal to end, or cancel it first.",
  failed_to_charge:
    "The robot touches the dock, but there is no current: look at the dock's power, and clean its contacts.",
  failed_to_control:
    "Check what is between robot and dock, then dock again; if it fails again, see the controller's log.",
  failed_to_detect_dock: "Move the robot closer and turn it to the dock, so that its camera sees the marker.",
  failed_to_stage: "Clear the way to the staging pose in front of the dock, or move the robot closer.",
  failed_to_undock: "Look at the robot: the dock may hold it, or something stands behind it.",
  infrared_lost:
    "Check that nothing stands between the dock's beacon and the robot's receivers, then dock again.",
  lost_marker: "Check that the marker is well lit and nothing stands in front of it, then dock again.",
  localization_lost: "Check the robot's localization: set its pose on the map, then dock again.",
  obstructed:
    "Clear the way to the dock, then dock again. If nothing is there, clean the laser scanner and check how it is mounted.",
  odometry_lost: "Check the robot's base driver: there are no messages on odom.",
  preempted: "A newer goal replaced it: see the list of goals.",
  pushed_off: "Something moved the robot off its dock: dock again.",
  scan_lost: "Check the laser scanner: there are no messages on scan.",
  send_goal_failure: "See whether the docking server behind this one runs, then send the goal again.",
  server_shutting_down: "Start the action server again, then dock again.",
  unknown: "See the log of the docking server.",
  stop_latched: "Release the stop, then send the goal again.",
  stopped: "If the stop still holds, release it before you send the goal again.",
  timeout: "Check the robot's way to the dock, or raise the server's goal_timeout.",
};

/** What can be done about a goal that does not go as it should. */
export function advice(goal: Pick<LiveGoal, "status" | "error" | "stalled">): string | null {
  if (goal.status === "lost") return FIND_IT;
  if (goal.error !== null) return ADVICE[goal.error.code] ?? adviceFor(goal.error.code);
  return goal.stalled ? STALLED : null;
}

const SHORT: Record<string, string> = {
  action_server_lost: "Lost contact with the action server",
  goal_unconfirmed: "Never confirmed by the action server",
  action_server_timeout: "Action server did not answer",
  action_server_unresponsive: "Action server does not answer",
  battery_lost: "Battery data stopped",
  blocked: "Robot was blocked",
  dock_busy: "Dock was busy",
  dock_not_in_db: "Dock is not known",
  dock_not_valid: "Type of the dock is not known",
  failed_to_dock: "Did not get onto the dock",
  failed_to_charge: "No charge on the dock",
  failed_to_control: "Dock was not reached",
  failed_to_detect_dock: "Dock was not found",
  failed_to_stage: "Staging pose was not reached",
  failed_to_undock: "Did not get off the dock",
  goal_aborted: "No reason given",
  result_too_large: "Result too large to show",
  infrared_lost: "Beacon was lost",
  lost_marker: "Marker was lost",
  localization_lost: "Localization was lost",
  obstructed: "Obstacle in the way",
  odometry_lost: "Odometry data stopped",
  preempted: "Replaced by a newer goal",
  pushed_off: "Pushed off the dock",
  scan_lost: "Laser scan stopped",
  server_shutting_down: "Action server shut down",
  stop_latched: "A stop was latched",
  timeout: "Took too long",
  unknown: "Unexpected error in the server",
};

/** What an error code means, in a few words. */
export function codeWords(code: string): string {
  if (code === "stopped") return "A stop was requested";
  return SHORT[code] ?? sentence(code.replaceAll("_", " "));
}

const REACHED: Record<Verb, string> = { dock: "Reached the dock", undock: "Left the dock" };

/** A few words for a table; the goal's page says more. */
export function outcome(goal: Meant): string {
  const { error, status } = goal;
  if (error?.code === "stopped" && isTerminal(status)) {
    return status === "rejected" ? "Not sent: a stop came first" : "Canceled by a stop";
  }
  if (error !== null) return SHORT[error.code] ?? error.detail;
  if (status === "succeeded" && goal.verb) return REACHED[goal.verb];
  if (goal.stalled) return "Server not responding";
  if (status === "succeeded") return "Done";
  if (status === "canceled") return "On request";
  return goal.stage === null || isTerminal(status) ? "–" : stageName(goal.stage);
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

/** What names a goal: its message, where that is known, may name a dock. */
export type Named = Pick<GoalSummary, "verb" | "action_name"> & { goal?: unknown };

/** What a robot's goal is called: `Dock`, `Undock`, `Dock at charger_2`; `Navigate to pose` by its action's name. */
export function goalName({ verb, action_name, goal }: Named): string {
  if (!verb) return sentence(action_name.slice(action_name.lastIndexOf("/") + 1).replaceAll("_", " "));
  const dock = verb === "dock" ? dockOf(goal) : null;
  return dock === null ? sentence(verb) : `${sentence(verb)} at ${dock}`;
}

/** The dock that a goal's message names; null for none. */
export function dockOf(message: unknown): string | null {
  const { dock_id, use_dock_id } = Object(message) as Record<string, unknown>;
  return typeof dock_id === "string" && dock_id !== "" && use_dock_id !== false ? dock_id : null;
}

/** A goal wherever it is listed with others: `Dock, Left forklift`, `Navigate to pose, /robot1`. */
export function goalTitle(goal: Named, naming: Naming): string {
  const robot = naming.actorOf(goal.action_name);
  return robot === null ? goalName(goal) : `${goalName(goal)}, ${robot}`;
}

/** `Dock: Controlling`, `Undock: canceling`, `Fibonacci: executing` */
export function runningWords(goal: GoalSummary): string {
  const stage = goal.status === "executing" ? stageLabel(goal.stage) : null;
  return `${goalName(goal)}: ${stage ?? goal.status}`;
}

/** How a goal ended, in a few words. */
export function lastWords(goal: GoalSummary): string {
  const told = goal.verb && (goal.error !== null || goal.status === "succeeded");
  return told ? sentence(outcome(goal)) : `${goalName(goal)} ${goal.status}`;
}

/** When a goal was created, and when it ended. */
export type Lifetime = Pick<LiveGoal, "created_at" | "finished_at">;

/**
 * How long a goal took, as the exported `duration_s` says, or has been running for: then in whole seconds, so that what
 * is renewed at different times says the same.
 *
 * @param now In the gateway's time (ms).
 */
export function durationWords({ created_at, finished_at }: Lifetime, now: number): string {
  const start = Date.parse(created_at);
  return finished_at === null ? soFarWords(start, now) : formatDuration(Date.parse(finished_at) - start);
}

/** For how long a goal has been running, in whole seconds. */
export function soFarWords(start: number, now: number): string {
  const seconds = Math.max(0, Math.floor((now - start) / 1000));
  return seconds < 10 ? `${seconds} s` : formatDuration(seconds * 1000);
}

/**
 * Why a goal cannot be canceled now, in a sentence; null where it can. One that is lost can be: its server may come back.
 *
 * @param goal Null where none is running.
 * @param canceling Whether the request is under way.
 */
export function whyNotCancel(
  live: boolean,
  goal: Pick<LiveGoal, "status"> | null,
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
