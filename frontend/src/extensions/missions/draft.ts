import { type Draft as GoalDraft, outgoing, spaced } from "../../actions/form/draft";
import type { MessageShape } from "../../actions/form/shapes";
import type { FieldError } from "../../actions/form/write";
import type { Json, JsonObject } from "../../api/jsonSchema";
import { LIMITS } from "../../api/limits.gen";
import { clockOf, dayOf, timeAt } from "../../ui/time";
import { PRIORITY } from "./queue";
import type { Mission, MissionStep, Waypoint } from "./requests";
import { depthOf } from "./words";

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
  | "first_that_works";
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
  /** What is sent there, or the steps inside of it: JSON, as it was typed. */
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

/** What starts a mission once more. */
export function draftOf(mission: Mission, now: number, defaultRobot = "/"): Draft {
  const { robot, group, name, priority, battery } = mission;
  return {
    robot: robot ?? defaultRobot,
    group,
    name: name ?? "",
    priority,
    battery: batteryOf(battery),
    steps: mission.steps
      .filter((step) => depthOf(step) === 0)
      .map((step) => stepOf(step, mission.steps, now)),
    refused: [],
  };
}

/** What a robot charges for, unless somebody says otherwise. */
export const USUAL_BATTERY: BatteryDraft = { below: 25, chargeTo: 80 };

/** When a robot returns to charge, in percent. */
export function batteryOf(battery: Mission["battery"]): BatteryDraft | null {
  return battery && { below: percentOf(battery.below), chargeTo: percentOf(battery.charge_to) };
}

/** When a robot returns to charge, as it is sent. */
export function limitsOf(battery: BatteryDraft | null): Mission["battery"] {
  return battery && { below: chargeOf(battery.below), charge_to: chargeOf(battery.chargeTo) };
}

/** In percent, with a tenth. */
function percentOf(charge: number): number {
  return Math.round(charge * 1000) / 10;
}

/** 0 to 1. */
function chargeOf(percent: number | string): number {
  return Math.round(Number(percent) * 10) / 1000;
}

/** The request of the steps inside of a step, of all those of a mission. */
function insideOf(step: MissionStep, all: readonly MissionStep[]): Json[] {
  const list = `${step.path}.${step.repeat === null ? "first_that_works" : "repeat.steps"}.`;
  return all
    .filter(({ path }) => path.startsWith(list) && /^\d+$/.test(path.slice(list.length)))
    .map((each) => requestOf(each, all));
}

const SINGLE = ["dock", "undock", "navigate", "action", "wait", "notify", "call", "publish"] as const;

/** A step as it was sent, with those inside of it. */
function requestOf(step: MissionStep, all: readonly MissionStep[]): Json {
  const { repeat, first_that_works, name, timeout_s, tries, on_failure, interruptible } = step;
  const entries: [string, unknown][] = SINGLE.map((kind) => [kind, step[kind]]);
  if (repeat !== null) entries.push(["repeat", { times: repeat.times, steps: insideOf(step, all) }]);
  if (first_that_works !== null) entries.push(["first_that_works", insideOf(step, all)]);
  entries.push(["name", name], ["timeout_s", timeout_s]);
  if (tries !== 1) entries.push(["tries", tries]);
  if (on_failure !== "end") entries.push(["on_failure", on_failure]);
  if (interruptible) entries.push(["interruptible", true]);
  return Object.fromEntries(entries.filter(([, value]) => value !== null)) as Json;
}

function stepOf(step: MissionStep, all: readonly MissionStep[], now: number): StepDraft {
  const draft = (kind: StepKind, fields: Partial<StepDraft>) =>
    newStep(kind, now, {
      name: step.name ?? "",
      timeout: step.timeout_s ?? "",
      tries: step.tries,
      onFailure: step.on_failure,
      interruptible: step.interruptible,
      ...fields,
    });
  const content = () => JSON.stringify(insideOf(step, all), null, 1);
  if (step.repeat !== null) return draft("repeat", { times: step.repeat.times ?? "", content: content() });
  if (step.first_that_works !== null) return draft("first_that_works", { content: content() });
  if (step.dock !== null) {
    const { dock_id, ...request } = step.dock;
    const dock = typeof dock_id === "string" ? dock_id : "";
    return draft("dock", { dock, request: request as JsonObject });
  }
  if (step.undock !== null) return draft("undock", { request: step.undock as JsonObject });
  if (step.action !== null) {
    const { name, goal } = step.action;
    return draft("action", { action: name, message: (goal ?? {}) as Json });
  }
  if (step.navigate !== null) return draft("navigate", placeOf(step.navigate));
  if (step.call !== null) {
    const { service, request, type } = step.call;
    return draft("call", { target: service, type: type ?? "", content: spaced(request as Json) });
  }
  if (step.publish !== null) {
    const { topic, message, type } = step.publish;
    return draft("publish", { target: topic, type: type ?? "", content: spaced(message as Json) });
  }
  if (step.notify !== null) return draft("notify", step.notify);
  return draft("wait", waitOf(step.wait));
}

function placeOf({ place, pose, poses }: NonNullable<MissionStep["navigate"]>): Partial<StepDraft> {
  if (place !== null) return { placeId: place };
  if (pose === null) return { places: poses };
  const { x, y, yaw, frame } = pose;
  return { place: { x, y, heading: Math.round((yaw * 180_000) / Math.PI) / 1000, frame } };
}

function waitOf(wait: MissionStep["wait"]): Partial<StepDraft> {
  if (wait?.seconds != null) return { wait: "seconds", seconds: wait.seconds };
  if (wait?.battery != null) return { wait: "battery", charge: percentOf(wait.battery) };
  if (wait?.until == null) return { wait: "person" };
  const until = Date.parse(wait.until);
  return { wait: "until", day: dayOf(until), clock: clockOf(until) };
}

/** The steps with one of them moved by a place, or as they are where it cannot be. */
export function withMoved(steps: readonly StepDraft[], index: number, by: -1 | 1): readonly StepDraft[] {
  const [moved, other] = [steps[index], steps[index + by]];
  if (moved === undefined || other === undefined) return steps;
  return steps.map((step, at) => (at === index ? other : at === index + by ? moved : step));
}

/** The request that starts a mission: JSON, as goals are written, so that no number in them is rounded. */
export function bodyOf({ group, name, priority, battery, steps }: Draft, by: string | null): string {
  const limits = limitsOf(battery);
  const fields = { name: name.trim() || null, priority: Number(priority), by };
  const own = { ...fields, ...(limits && { battery: limits }) };
  const head = JSON.stringify(group === null ? own : { ...own, group });
  return `${head.slice(0, -1)},"steps":[${steps.map(stepText).join(",")}]}`;
}

function stepText(step: StepDraft): string {
  const name = step.name.trim() === "" ? {} : { name: step.name.trim() };
  if (isBlock(step.kind)) {
    const inside =
      step.kind === "first_that_works"
        ? step.content
        : `{"times":${step.times === "" ? "null" : Number(step.times)},"steps":${step.content}}`;
    return `{"${step.kind}":${inside},${JSON.stringify({ ...name, on_failure: step.onFailure }).slice(1)}`;
  }
  const options = {
    ...name,
    ...(step.timeout === "" ? {} : { timeout_s: Number(step.timeout) }),
    tries: Number(step.tries),
    on_failure: step.onFailure,
    ...(isInterruptible(step.kind) && step.interruptible ? { interruptible: true } : {}),
  };
  return `{"${step.kind}":${whatText(step)},${JSON.stringify(options).slice(1)}`;
}

function whatText(step: StepDraft): string {
  if (step.kind === "action") {
    const goal =
      step.goal === null ? JSON.stringify(step.message) : outgoing(step.goal.draft, step.goal.shape).body;
    return `{"name":${JSON.stringify(step.action)},"goal":${goal ?? "{}"}}`;
  }
  switch (step.kind) {
    case "wait":
      return JSON.stringify(waitBody(step));
    case "navigate":
      return JSON.stringify(navigateBody(step));
    case "notify":
      return JSON.stringify({ text: step.text.trim(), critical: step.critical });
    case "call":
      return `${messageHead("service", step)},"request":${step.content}}`;
    case "publish":
      return `${messageHead("topic", step)},"message":${step.content}}`;
  }
  return JSON.stringify(
    step.dock === "" || step.kind === "undock" ? step.request : { ...step.request, dock_id: step.dock },
  );
}

function messageHead(name: string, { target, type }: StepDraft): string {
  return JSON.stringify({ [name]: target.trim(), type: type.trim() || null }).slice(0, -1);
}

function navigateBody({ placeId, place, places }: StepDraft) {
  if (placeId !== "") return { place: placeId };
  if (places !== null) return { poses: places };
  const { x, y, heading, frame } = place;
  const yaw = (Number(heading) * Math.PI) / 180;
  return { pose: { x: Number(x), y: Number(y), yaw, frame: frame.trim() } };
}

function waitBody({ wait, seconds, day, clock, charge }: StepDraft) {
  switch (wait) {
    case "seconds":
      return { seconds: Number(seconds) };
    case "battery":
      return { battery: chargeOf(charge) };
    case "until":
      return { until: new Date(timeAt(day, clock) ?? 0).toISOString() };
    case "person":
      return { person: true };
  }
}
