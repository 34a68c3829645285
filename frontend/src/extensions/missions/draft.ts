import type { Draft as GoalDraft } from "../../actions/form/draft";
import type { MessageShape } from "../../actions/form/shapes";
import type { FieldError } from "../../actions/form/write";
import type { Json, JsonObject } from "../../api/jsonSchema";
import { LIMITS } from "../../api/limits.gen";
import { clockOf, dayOf } from "../../ui/time";
import { PRIORITY } from "./queue";
import type { MissionStep, Waypoint } from "./requests";

const LIMITS_OF_MISSION = LIMITS["POST /missions"];
export const { maxLength: MAX_NAME } = LIMITS_OF_MISSION.name;
export const { minimum: MIN_PRIORITY, maximum: MAX_PRIORITY } = LIMITS_OF_MISSION.priority;
export const { maxItems: MAX_STEPS } = LIMITS_OF_MISSION.steps;
export const { minimum: MIN_TIMEOUT_S, maximum: MAX_TIMEOUT_S } = LIMITS_OF_MISSION["steps[].timeout_s"];
export const { minimum: MIN_TRIES, maximum: MAX_TRIES } = LIMITS_OF_MISSION["steps[].tries"];
export const { maximum: MAX_TIMES } = LIMITS_OF_MISSION["steps[].repeat.times"];
export const { maximum: MAX_BELOW } = LIMITS_OF_MISSION["battery.below"];
export const { maxLength: MAX_STEP_NAME } = LIMITS_OF_MISSION["steps[].name"];
export const { maxLength: MAX_NOTICE } = LIMITS_OF_MISSION["steps[].notify.text"];
export const { maximum: MAX_WAIT_S } = LIMITS_OF_MISSION["steps[].wait.seconds"];

export type StepKind =
  | "dock"
  | "undock"
  | "navigate"
  | "action"
  | "wait"
  | "notify"
  | "call"
  | "publish"
  | "repeat"
  | "first_that_works"
  | "json";
export type WaitKind = "seconds" | "until" | "battery" | "person";

/** A goal as it is filled in, with what its form is made of. */
export interface GoalForm {
  shape: MessageShape;
  draft: GoalDraft;
}

/** A step as it is put together. Fields of other kinds keep what was typed. */
export interface StepDraft {
  /** Tells it from others, wherever it is moved. */
  key: string;
  kind: StepKind;
  /** What a request to dock or undock has besides the name of the dock. */
  request: JsonObject;
  /** The name of a dock; empty for the default one. */
  dock: string;
  /** By which other steps go to it; empty for none. */
  name: string;
  /** The name of an action; empty before one is chosen. */
  action: string;
  /** The goal, as it is sent until it is filled in here. */
  message: Json;
  /** Null until somebody changes the goal. */
  goal: GoalForm | null;
  /** The id of the place to drive to; empty for a pose. */
  placeId: string;
  /** Where to drive, in metres and degrees. */
  place: { x: number | string; y: number | string; heading: number | string; frame: string };
  /** How often; empty: for ever. */
  times: number | string;
  /** Several places, as they were sent: they are not edited here. */
  places: Waypoint[] | null;
  /** The name of a service or a topic. */
  target: string;
  /** Its type; empty where it has only one. */
  type: string;
  /** What is sent there, the steps inside of it, or all of the step: JSON, as it was typed. */
  content: string;
  /** What people are told. */
  text: string;
  critical: boolean;
  wait: WaitKind;
  seconds: number | string;
  day: string;
  clock: string;
  /** In percent. */
  charge: number | string;
  /** In seconds; empty for no limit. */
  timeout: number | string;
  tries: number | string;
  onFailure: MissionStep["on_failure"];
  /** Whether its goal is canceled when the robot has to charge. */
  interruptible: boolean;
  /** What the gateway has refused, by paths from the step on: `wait.seconds`. */
  refused: readonly FieldError[];
}

/** When the robot returns to charge, and until when, in percent. */
export interface BatteryDraft {
  below: number | string;
  chargeTo: number | string;
}

/** A mission as it is put together. */
export interface Draft {
  /** Its namespace. */
  robot: string;
  /** Any robot of this group takes it; null for the robot. */
  group: string | null;
  name: string;
  priority: number | string;
  /** Null: the mission does not return by itself. */
  battery: BatteryDraft | null;
  steps: readonly StepDraft[];
  /** What the gateway has refused, besides what is in steps. */
  refused: readonly FieldError[];
}

/** Whether it sends a goal that can be left for the battery. */
export function isInterruptible(kind: StepKind): boolean {
  return kind === "action" || kind === "navigate";
}

/** Whether it has steps inside of it. */
export function isBlock(kind: StepKind): kind is "repeat" | "first_that_works" {
  return kind === "repeat" || kind === "first_that_works";
}

let made = 0;

/** A new step. @param now In the gateway's time (ms). */
export function newStep(kind: StepKind, now: number, change: Partial<StepDraft> = {}): StepDraft {
  made += 1;
  const inAnHour = now + 3_600_000;
  return {
    key: `step-${made}`,
    kind,
    request: {},
    dock: "",
    name: "",
    action: "",
    message: {},
    goal: null,
    placeId: "",
    place: { x: "", y: "", heading: 0, frame: "map" },
    places: null,
    target: "",
    type: "",
    times: 2,
    content: isBlock(kind) ? '[{"wait": {"seconds": 60}}]' : "{}",
    text: "",
    critical: false,
    wait: "seconds",
    seconds: 60,
    day: dayOf(inAnHour),
    clock: clockOf(inAnHour),
    charge: 80,
    timeout: "",
    tries: 1,
    onFailure: "end",
    interruptible: false,
    refused: [],
    ...change,
  };
}

export function newMission(robot: string): Draft {
  return { robot, group: null, name: "", priority: PRIORITY, battery: null, steps: [], refused: [] };
}

/** A mission to start from: charge the robot, and drive off the dock. */
export function exampleMission(robot: string, now: number): Draft {
  const steps = [
    newStep("dock", now, { tries: 3 }),
    newStep("wait", now, { wait: "battery", charge: 80 }),
    newStep("undock", now),
  ];
  return { ...newMission(robot), name: "Charge", steps };
}

/** What a robot charges for, unless somebody says otherwise. */
export const USUAL_BATTERY: BatteryDraft = { below: 25, chargeTo: 80 };

/** The steps with one of them moved by a place, or as they are where it cannot be. */
export function withMoved(steps: readonly StepDraft[], index: number, by: -1 | 1): readonly StepDraft[] {
  const [moved, other] = [steps[index], steps[index + by]];
  if (moved === undefined || other === undefined) return steps;
  return steps.map((step, at) => (at === index ? other : at === index + by ? moved : step));
}
