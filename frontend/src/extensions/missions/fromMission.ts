import { spaced } from "../../actions/form/draft";
import type { Json, JsonObject } from "../../api/jsonSchema";
import { clockOf, dayOf } from "../../ui/time";
import { type BatteryDraft, type Draft, newStep, type StepDraft, type StepKind } from "./draft";
import type { Mission, MissionStep } from "./requests";
import { depthOf } from "./words";

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

/** When a robot returns to charge, in percent. */
export function batteryOf(battery: Mission["battery"]): BatteryDraft | null {
  return battery && { below: percentOf(battery.below), chargeTo: percentOf(battery.charge_to) };
}

/** In percent, with a tenth. */
export function percentOf(charge: number): number {
  return Math.round(charge * 1000) / 10;
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

/** A step as it is put together. @param all The steps of the mission. */
export function stepOf(step: MissionStep, all: readonly MissionStep[], now: number): StepDraft {
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
