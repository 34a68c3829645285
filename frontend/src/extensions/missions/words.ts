import { formatPercentage } from "../../battery/words";
import type { Naming } from "../../fleet/names";
import { codeWords } from "../../goal/words";
import { sentence } from "../../ui/text";
import { formatDuration, formatTime } from "../../ui/time";
import type { Mission, MissionStatus, MissionStep, Reason } from "./requests";

interface Look {
  words: string;
  color: string;
}

export const STATUSES: Record<MissionStatus, Look> = {
  queued: { words: "Queued", color: "gray" },
  running: { words: "Running", color: "blue" },
  held: { words: "Held", color: "orange" },
  canceling: { words: "Canceling", color: "orange" },
  succeeded: { words: "Succeeded", color: "green" },
  failed: { words: "Failed", color: "red" },
  canceled: { words: "Canceled", color: "gray" },
};

/** A sign that is read besides the color of a step, and the word for it. */
export const STEP_STATES: Record<MissionStep["status"], { sign: string; words: string }> = {
  waiting: { sign: "", words: "Not yet" },
  running: { sign: "", words: "Now" },
  succeeded: { sign: "✓", words: "Done" },
  failed: { sign: "✕", words: "Failed" },
  skipped: { sign: "–", words: "Skipped" },
  canceled: { sign: "–", words: "Canceled" },
};

const ERRORS: Record<string, string> = {
  step_timeout: "Took longer than its timeout",
  not_sent: "The goal could not be sent within 23 hours",
  goal_not_found: "The history no longer has its goal",
  place_not_found: "The place is not there any more",
  goal_canceled: "The goal was canceled",
  invalid_field: "The action does not accept this goal",
  low_battery: "The robot charges first, as its battery is low",
  off_charger: "The battery was discharging on the dock",
  step_interrupted: "The gateway ended during this step: nobody knows whether it was carried out",
};

/** What the gateway says of an error besides the words for it; null where that is the same. */
export function errorDetail({ code, detail }: Reason): string | null {
  return code in ERRORS && code !== "invalid_field" ? null : sentence(detail);
}

/** What a step or a mission ended with, in a few words. */
export function errorWords({ code }: Reason): string {
  return ERRORS[code] ?? codeWords(code);
}

type StepFields = Pick<
  MissionStep,
  | "repeat"
  | "first_that_works"
  | "dock"
  | "undock"
  | "action"
  | "navigate"
  | "call"
  | "publish"
  | "notify"
  | "wait"
>;

/** `Dock at lab`, `Undock`, `Fibonacci`, `Wait 1 min 00 s` */
export function stepWords(step: StepFields): string {
  const { dock, undock, action, navigate, call, publish, notify, wait, repeat, first_that_works } = step;
  if (repeat !== null) return repeatWords(repeat);
  if (first_that_works !== null) return `The first of ${first_that_works.alternatives} that works`;
  if (dock !== null) {
    const { dock_id } = dock;
    return typeof dock_id === "string" && dock_id !== "" ? `Dock at ${dock_id}` : "Dock";
  }
  if (undock !== null) return "Undock";
  if (action !== null) return actionWords(action.name);
  if (navigate !== null) return navigateWords(navigate);
  if (call !== null) return `Call ${call.service}`;
  if (publish !== null) return `Publish on ${publish.topic}`;
  if (notify !== null) return `Tell people: ${notify.text}`;
  return wait === null ? "" : waitWords(wait);
}

/** `Navigate to pose` */
export function actionWords(name: string): string {
  return sentence(name.slice(name.lastIndexOf("/") + 1).replaceAll("_", " "));
}

/** `Repeat 3 times`, `Repeat for ever, round 7` */
function repeatWords({ times, round }: NonNullable<MissionStep["repeat"]>): string {
  const words = times === null ? "Repeat for ever" : times === 1 ? "Once" : `Repeat ${times} times`;
  return round === 0 || times === 1 ? words : `${words}, round ${round}`;
}

/** How deep a step is inside of others. */
export function depthOf({ path }: Pick<MissionStep, "path">): number {
  return (path.match(/\.\d+/g) ?? []).length;
}

/** `2.1` for the first step inside of the second one. */
export function numberOf({ path }: Pick<MissionStep, "path">): string {
  return (path.match(/\d+/g) ?? []).map((each) => Number(each) + 1).join(".");
}

/** `Step 2 of 3`; `Step 2.1` where steps are inside of others. */
export function stepPlace({ steps, step }: Pick<Mission, "steps" | "step">): string {
  const present = steps[step];
  if (present === undefined || steps.every((each) => depthOf(each) === 0))
    return `Step ${step + 1} of ${steps.length}`;
  return `Step ${numberOf(present)}`;
}

/** `Drive to x 1.2 m, y 3.4 m`, `Drive through 3 places` */
function navigateWords({ place, pose, poses }: NonNullable<MissionStep["navigate"]>): string {
  if (place !== null) return `Drive to ${place}`;
  if (pose === null) return `Drive through ${poses?.length ?? 0} places`;
  const { x, y, frame } = pose;
  return `Drive to x ${x} m, y ${y} m${frame === "map" ? "" : ` in ${frame}`}`;
}

function waitWords({ seconds, until, battery }: NonNullable<MissionStep["wait"]>): string {
  if (seconds !== null) return `Wait ${secondsWords(seconds)}`;
  if (until !== null) return `Wait until ${formatTime(Date.parse(until))}`;
  if (battery !== null) return `Wait until the battery has ${formatPercentage(battery)}`;
  return "Wait until someone continues";
}

/** `2 s`, `1 min 30 s` */
export function secondsWords(seconds: number): string {
  return seconds < 10 ? `${seconds} s` : formatDuration(seconds * 1000);
}

/** Its name, else its steps: `Dock, Wait 2 s, Undock`. */
export function missionName({ name, steps }: Pick<Mission, "name" | "steps">): string {
  if (name !== null && name.trim() !== "") return name;
  const outer = steps.filter((step) => depthOf(step) === 0);
  const first = outer.slice(0, 3).map(stepWords).join(", ");
  return outer.length > 3 ? `${first}, …` : first;
}

interface Hold {
  title: string;
  words: string;
}

/** Why a mission is held, and what Continue does then. */
const HOLDS: Record<NonNullable<Mission["held_for"]>, Hold> = {
  stop: {
    title: "The robot was stopped",
    words: "The mission does not go on by itself. Continue begins this step again.",
  },
  canceled: { title: "The goal of this step was canceled", words: "Continue begins the step again." },
  lost: {
    title: "Lost contact during this step",
    words: "Check where the robot is and what it has done. Continue begins the step again.",
  },
  person: { title: "Waiting for a person", words: "Check the robot, then press Continue." },
  paused: { title: "Paused", words: "Continue goes on with this step." },
  approval: {
    title: "An agent asks for it",
    words: "Check its steps and that the area is clear. Continue lets it begin; Cancel refuses it.",
  },
  recharge: {
    title: "The robot could not be charged",
    words: "Check the robot and its dock. Continue tries it again; Skip step goes on without it.",
  },
};
const NOT_BEGUN: Hold = { title: "Paused", words: "It does not begin until someone continues it." };

/** Why a mission is held; null where it is not. */
export function holdOf({ held_for, started_at }: Pick<Mission, "held_for" | "started_at">): Hold | null {
  if (held_for === null) return null;
  return started_at === null && held_for !== "approval" ? NOT_BEGUN : HOLDS[held_for];
}

/** Who takes a mission: its robot, or one of its group. */
export function takerWords({ robot, group }: Pick<Mission, "robot" | "group">, naming: Naming): string {
  return robot === null ? `Any of ${group}` : naming.nameOf(robot);
}

/** What a mission for a group waits for before a robot begins it; empty where that is not known. */
export function groupWaitWords({ waits_for }: Pick<Mission, "waits_for">): string {
  if (waits_for === "continue")
    return "The robots that are free were stopped after it was queued. Continue lets one begin.";
  return waits_for === null ? "" : WAITS[waits_for];
}

const WAITS: Record<NonNullable<Mission["waits_for"]>, string> = {
  turn: "Waiting for its turn",
  robot: "Waiting for a robot of the group that is free and has enough charge",
  group: "No robot is in this group. A robot's page has its groups.",
  continue: "Waiting for Continue",
  stop_released: "Waiting for the stop to be released",
  other_goal: "Another goal is running on this robot. The step begins when it has ended.",
  retry: "Waiting for the next try",
  time: "Waiting",
  battery: "Waiting for the battery",
  goal: "The goal is running",
  answer: "Waiting for the answer of the service",
  server: "No action server for this step. It begins as soon as there is one.",
  dock: "Another robot has the dock. The step begins when it is free.",
  lost_goal: "Lost contact with the action server. Waiting for it to come back.",
  history: "The history does not answer. Nothing begins without it.",
};

const RECHARGES: Record<NonNullable<Mission["recharge"]>["stage"], string> = {
  docking: "Returning to its dock",
  charging: "Charging",
  undocking: "Leaving its dock",
};

/** What the robot does during a break for its battery; null: it is at its step. */
export function breakWords({ recharge }: Pick<Mission, "recharge">): string | null {
  return recharge && RECHARGES[recharge.stage];
}

/** `Returns below 25 %, charges to 80 %` */
export function limitWords({ below, charge_to }: NonNullable<Mission["battery"]>): string {
  return `Returns below ${formatPercentage(below)}, charges to ${formatPercentage(charge_to)}`;
}

/**
 * What a mission that is on its way waits for.
 *
 * @param charge Of the robot's battery, 0 to 1; null where it is unknown.
 * @param now In the gateway's time (ms).
 */
export function nowWords(mission: Mission, charge: number | null, now: number): string {
  if (mission.status === "canceling") return "Its goal is being canceled.";
  const step = mission.steps[mission.step];
  if (mission.waits_for === null || step === undefined) return "";
  if (mission.wait_at != null)
    return mission.waits_for === "dock" ? WAITS.dock : "Driving to where it waits for the dock";
  if (mission.recharge !== null) return rechargeWords(mission, charge);
  if (mission.waits_for === "battery" && step.wait?.battery != null) {
    const goal = `goes on at ${formatPercentage(step.wait.battery)}`;
    return charge === null
      ? `The battery's charge is unknown; ${goal}`
      : `Battery at ${formatPercentage(charge)}; ${goal}`;
  }
  if (mission.waits_for === "time") {
    const end = endOf(step);
    if (end !== null)
      return end > now ? `Goes on in ${secondsWords(Math.ceil((end - now) / 1000))}` : "Going on";
  }
  if (mission.waits_for === "retry") return `Try ${step.attempt + 1} of ${step.tries} begins within seconds`;
  return WAITS[mission.waits_for];
}

/** What a break waits for. */
function rechargeWords({ recharge, battery, waits_for }: Mission, charge: number | null): string {
  if (recharge === null || waits_for === null) return "";
  if (waits_for === "retry") return `Try ${recharge.tried + 1} begins within half a minute`;
  if (recharge.stage !== "charging" || waits_for !== "battery") return WAITS[waits_for];
  const level =
    charge === null ? "The battery's charge is unknown" : `Battery at ${formatPercentage(charge)}`;
  return battery === null ? level : `${level}; the mission goes on at ${formatPercentage(battery.charge_to)}`;
}

/** When a step that waits for a time ends (ms); null for other steps. */
function endOf({ wait, started_at }: MissionStep): number | null {
  if (wait?.until != null) return Date.parse(wait.until);
  if (wait?.seconds == null || started_at === null) return null;
  return Date.parse(started_at) + wait.seconds * 1000;
}

/** How its options differ from the default ones: `3 tries, 60 s each, then the next step`; empty where they do not. */
export function optionWords({
  tries,
  timeout_s,
  on_failure,
  interruptible,
}: Pick<MissionStep, "tries" | "timeout_s" | "on_failure" | "interruptible">): string {
  const words = [
    ...(tries > 1 ? [`up to ${tries} tries`] : []),
    ...(timeout_s === null ? [] : [`at most ${secondsWords(timeout_s)}`]),
    ...(on_failure === "next" ? ["goes on if it fails"] : []),
    ...(typeof on_failure === "object" ? [`goes to ${on_failure.go_to} if it fails`] : []),
    ...(interruptible ? ["left to charge"] : []),
  ];
  return words.join(", ");
}

/** How long it took, or has been on its way; empty before it began. @param now In the gateway's time (ms). */
export function tookWords(
  { started_at, finished_at }: Pick<Mission, "started_at" | "finished_at">,
  now: number,
): string {
  if (started_at === null) return "";
  const ms = (finished_at === null ? now : Date.parse(finished_at)) - Date.parse(started_at);
  return secondsWords(Math.max(0, Math.round(ms / 1000)));
}
