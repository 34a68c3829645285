import { isTerminal } from "@dock-gateway/client";
import type { GoalCourse } from "../store/goals";
import type { StageVisit } from "../store/stages";
import { sentence } from "../ui/text";

export type StepState = "done" | "current" | "failed" | "canceled" | "unknown" | "waiting";

interface Step {
  stage: string;
  label: string;
  state: StepState;
}

const LABELS: Record<string, string> = {
  INITIAL_PERCEPTION: "Perception",
  NAV_TO_STAGING_POSE: "Staging",
  CONTROLLING: "Controlling",
  WAIT_FOR_CHARGE: "Wait for charge",
  UNDOCKING: "Backing out",
};

const SHORT: Record<string, string> = {
  RETRY: "Backing off",
  CORRECTING: "Pressing again",
  RETURN_TO_STAGING: "Back to staging",
  WAIT_FOR_BATTERY: "Waiting for the battery",
  WAIT_FOR_ODOMETRY: "Waiting for odometry",
  WAIT_FOR_CLEARANCE: "Waiting for a clear way",
};

/** A stage in a word or two; null where it is none of the way. */
export function stageLabel(stage: string | null): string | null {
  return stage === null ? null : (LABELS[stage] ?? SHORT[stage] ?? null);
}

const DOCKING = ["INITIAL_PERCEPTION", "NAV_TO_STAGING_POSE", "CONTROLLING", "WAIT_FOR_CHARGE"];
const UNDOCKING = ["UNDOCKING"];
/** The ways of other servers' goals: nav2 knows where its docks are, and looks for the dock once it is in front of it. */
const OTHER_WAYS: Record<string, readonly string[]> = {
  "nav2_msgs/action/DockRobot": [
    "NAV_TO_STAGING_POSE",
    "INITIAL_PERCEPTION",
    "CONTROLLING",
    "WAIT_FOR_CHARGE",
  ],
  "irobot_create_msgs/action/Dock": ["INITIAL_PERCEPTION", "CONTROLLING"],
};

/**
 * The way of a goal, step by step, and how far it is; none where the action server tells no stages. A controller that
 * only controls, as `rotate` does, has that one step.
 *
 * @param seen The stages that the goal was seen in, in order.
 */
export function stepsOf(goal: GoalCourse, seen: readonly string[]): Step[] {
  const other = OTHER_WAYS[goal.action_type];
  const all = other ?? (goal.verb === "undock" ? UNDOCKING : DOCKING);
  const known = seen.filter((stage) => all.includes(stage));
  const last = known.at(-1);
  if (last === undefined) return [];
  const way = !other && known.every((stage) => stage === "CONTROLLING") ? ["CONTROLLING"] : all;
  const reached = way.indexOf(last);
  const failed = Math.max(seen.lastIndexOf("RETRY"), seen.lastIndexOf("RETURN_TO_STAGING"));
  const retrying = failed > seen.lastIndexOf(last);
  return way.map((stage, index) => ({
    stage,
    label: LABELS[stage] ?? stage,
    state: stateOf(goal, index - reached, retrying),
  }));
}

/** @param ahead How many steps the goal is before this one; negative where it is beyond. */
function stateOf(goal: GoalCourse, ahead: number, retrying: boolean): StepState {
  if (goal.status === "succeeded" || ahead < 0) return "done";
  if (ahead > 0) return "waiting";
  if (goal.status === "canceled") return "canceled";
  if (goal.status === "lost") return "unknown";
  return retrying || isTerminal(goal.status) ? "failed" : "current";
}

/** A stage as people write it, also one that is not ours: `Wait for charge`. */
export function stageName(stage: string): string {
  return stageLabel(stage) ?? sentence(stage.replaceAll("_", " ").toLowerCase());
}

const WORDS: Record<string, string> = {
  INITIAL_PERCEPTION: "Looking for the dock.",
  NAV_TO_STAGING_POSE: "Driving to the staging pose in front of the dock.",
  CONTROLLING: "Driving onto the dock until the battery is charging.",
  WAIT_FOR_CHARGE: "On the dock, waiting for the battery to charge.",
  RETRY: "Backing off to try again.",
  CORRECTING: "On the contacts without a charge: a little back, a little turn, and on again.",
  RETURN_TO_STAGING: "The last attempt failed: going back to the staging pose before the goal ends.",
  UNDOCKING: "Backing out of the dock.",
  WAIT_FOR_CLEARANCE: "An obstacle is in the way, or there is no laser scan: the robot stands still.",
  WAIT_FOR_BATTERY: "No battery data: the robot stands still until a battery state arrives.",
  WAIT_FOR_ODOMETRY: "No odometry: the robot stands still until it arrives.",
};

/** What a stage means, in a sentence; null where it is none of the way. */
export function stageWords(stage: string | null): string | null {
  return stage === null ? null : (WORDS[stage] ?? null);
}

/** A stage of a goal's way and how long it took, or has taken so far (ms); null where its begin is not known. */
interface StageSpan {
  stage: string;
  ms: number | null;
}

/** @param now In the gateway's time (ms). */
export function spansOf(goal: GoalCourse, visits: readonly StageVisit[], now: number): StageSpan[] {
  const end = isTerminal(goal.status) ? Date.parse(goal.finished_at ?? goal.updated_at) : now;
  return visits.map(({ stage, since }, index) => {
    const next = visits[index + 1];
    const until = next === undefined ? end : next.since;
    return { stage, ms: since === null || until === null ? null : Math.max(0, until - since) };
  });
}

/** How long a goal was in a stage, in all of its tries; null where that is not known. */
export function timeIn(stage: string, spans: readonly StageSpan[]): number | null {
  const times = spans.filter((span) => span.stage === stage).map(({ ms }) => ms);
  if (times.length === 0) return null;
  return times.reduce((sum, ms) => (sum === null || ms === null ? null : sum + ms), 0);
}
