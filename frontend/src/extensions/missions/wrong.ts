import { type Draft as GoalDraft, newDraft, outgoing } from "../../actions/form/draft";
import type { MessageShape } from "../../actions/form/shapes";
import type { FieldError } from "../../actions/form/write";
import { isObject } from "../../api/jsonSchema";
import { timeAt } from "../../ui/time";
import {
  type BatteryDraft,
  type Draft,
  isBlock,
  MAX_BELOW,
  MAX_PRIORITY,
  MAX_STEPS,
  MAX_TIMEOUT_S,
  MAX_TIMES,
  MAX_TRIES,
  MAX_WAIT_S,
  MIN_PRIORITY,
  MIN_TIMEOUT_S,
  MIN_TRIES,
  type StepDraft,
} from "./draft";
import { parsed } from "./written";

/** Something that is wrong with a field. */
export interface Wrong extends FieldError {
  /** Nothing was entered yet: it is said only after somebody has tried to start the mission. */
  missing?: true;
}

/** What is wrong with a mission itself, by the field. */
export function missionErrors({ priority, battery, steps }: Draft): Wrong[] {
  const errors: Wrong[] = battery === null ? [] : batteryErrors(battery);
  if (!isWithin(priority, MIN_PRIORITY, MAX_PRIORITY) || !Number.isInteger(priority))
    errors.push({ path: "priority", detail: `A whole number from ${MIN_PRIORITY} to ${MAX_PRIORITY}` });
  if (steps.length === 0) errors.push({ path: "steps", detail: "Add a step.", missing: true });
  if (steps.length > MAX_STEPS) errors.push({ path: "steps", detail: `At most ${MAX_STEPS} steps` });
  return errors;
}

/** In percent: what lies between the charge at which a robot returns and the one with which it goes on. */
const LEAST_CHARGE = 5;

/** What is wrong with when a robot returns, by the field. */
export function batteryErrors({ below, chargeTo }: BatteryDraft): Wrong[] {
  const highest = MAX_BELOW * 100;
  if (!isWithin(below, 1, highest)) return [{ path: "battery.below", detail: `From 1 to ${highest} %` }];
  const least = Math.round((Number(below) + LEAST_CHARGE) * 10) / 10;
  return isWithin(chargeTo, least, 100)
    ? []
    : [{ path: "battery.charge_to", detail: `From ${least} to 100 %` }];
}

/** What is wrong with a step, by paths from the step on. @param now In the gateway's time (ms). */
export function stepErrors(step: StepDraft, now: number): Wrong[] {
  if (step.kind === "json")
    return isObject(parsed(step.content)) || isParameter(step.content)
      ? []
      : [{ path: "", detail: 'A step as JSON, such as {"dock": {}}' }];
  const errors: Wrong[] = [...ownErrors(step, now)];
  if (step.timeout !== "" && !isWithin(step.timeout, MIN_TIMEOUT_S, MAX_TIMEOUT_S))
    errors.push({ path: "timeout_s", detail: "From 1 s to a week; empty for no limit" });
  if (!isWithin(step.tries, MIN_TRIES, MAX_TRIES) || !Number.isInteger(step.tries))
    errors.push({ path: "tries", detail: `From ${MIN_TRIES} to ${MAX_TRIES}` });
  return errors;
}

function ownErrors(step: StepDraft, now: number): Wrong[] {
  if (step.kind === "wait") return waitErrors(step, now);
  if (isBlock(step.kind)) return blockErrors(step, step.kind);
  if (step.kind === "navigate") return placeErrors(step);
  if (step.kind === "call" || step.kind === "publish") return messageErrors(step, step.kind);
  if (step.kind === "notify")
    return step.text.trim() === ""
      ? [{ path: "notify.text", detail: "Write a sentence.", missing: true }]
      : [];
  if (step.kind !== "action") return [];
  if (step.action === "") return [{ path: "action.name", detail: "Choose an action.", missing: true }];
  if (step.goal === null) return [];
  return outgoing(step.goal.draft, step.goal.shape).errors.map(({ path, detail }) => ({
    path: path === "" ? GOAL : `${GOAL}.${path}`,
    detail,
  }));
}

const GOAL = "action.goal";

/** In metres. */
const FARTHEST = 1e6;

function placeErrors({ placeId, place, places }: StepDraft): Wrong[] {
  if (placeId !== "" || places !== null) return [];
  const wrong = (["x", "y"] as const).flatMap((axis): Wrong[] =>
    place[axis] === ""
      ? [{ path: `navigate.pose.${axis}`, detail: "A number of metres", missing: true }]
      : isWithin(place[axis], -FARTHEST, FARTHEST)
        ? []
        : [{ path: `navigate.pose.${axis}`, detail: "A number of metres" }],
  );
  const turned: Wrong[] = isWithin(place.heading, -360, 360)
    ? []
    : [{ path: "navigate.pose.yaw", detail: "From -360° to 360°" }];
  const frame: Wrong[] =
    place.frame.trim() === "" ? [{ path: "navigate.pose.frame", detail: "The name of a frame" }] : [];
  return [...wrong, ...turned, ...frame];
}

/** The field of the name of a call or a message, and that of what is sent there. */
export const MESSAGE = {
  call: { name: "call.service", content: "call.request" },
  publish: { name: "publish.topic", content: "publish.message" },
} as const;

function messageErrors({ target, content }: StepDraft, kind: keyof typeof MESSAGE): Wrong[] {
  const { name, content: path } = MESSAGE[kind];
  const errors: Wrong[] = [];
  if (target.trim() === "") errors.push({ path: name, detail: "Enter a name.", missing: true });
  else if (!target.trim().startsWith("/")) errors.push({ path: name, detail: "A name that begins with /" });
  if (!isObject(parsed(content))) errors.push({ path, detail: 'JSON, such as {"data": true}' });
  return errors;
}

/** Where the steps inside of a step are. */
export const INSIDE = { repeat: "repeat.steps", first_that_works: "first_that_works" } as const;

function blockErrors({ times, content }: StepDraft, kind: keyof typeof INSIDE): Wrong[] {
  const errors: Wrong[] = [];
  if (kind === "repeat" && times !== "" && !(isWithin(times, 1, MAX_TIMES) && Number.isInteger(times)))
    errors.push({ path: "repeat.times", detail: "A whole number from 1; empty: for ever" });
  const steps = parsed(content);
  if (!Array.isArray(steps) || steps.length === 0)
    errors.push({ path: INSIDE[kind], detail: 'A list of steps, such as [{"dock": {}}]' });
  return errors;
}

/** Whether a whole step is a parameter of a template. */
function isParameter(text: string): boolean {
  const value = parsed(text);
  return typeof value === "string" && value.startsWith("$");
}

function waitErrors({ wait, seconds, day, clock, charge }: StepDraft, now: number): Wrong[] {
  if (wait === "seconds" && !isWithin(seconds, 0, MAX_WAIT_S))
    return [{ path: "wait.seconds", detail: "From 0 s to a week" }];
  if (wait === "battery" && !isWithin(charge, 0.1, 100))
    return [{ path: "wait.battery", detail: "From 0.1 to 100 %" }];
  if (wait !== "until") return [];
  const until = timeAt(day, clock);
  if (until === null) return [{ path: "wait.until", detail: "A day and a time, such as 06:00" }];
  return until < now ? [{ path: "wait.until", detail: "This time is in the past" }] : [];
}

function isWithin(value: number | string, lowest: number, highest: number): boolean {
  return typeof value === "number" && value >= lowest && value <= highest;
}

/** Whether nothing is wrong that this page can see. @param now In the gateway's time (ms). */
export function isReady(draft: Draft, now: number): boolean {
  return missionErrors(draft).length === 0 && draft.steps.every((step) => stepErrors(step, now).length === 0);
}

/** The goal of a step as a form has it. @param step Of an action. */
export function goalOf(step: StepDraft, shape: MessageShape): GoalDraft {
  const draft = step.goal?.draft ?? newDraft(shape, step.message);
  const refused = step.refused.filter(({ path }) => isAt(path, GOAL));
  return {
    ...draft,
    refused: refused.map(({ path, detail }) => ({ path: path.slice(GOAL.length + 1), detail })),
  };
}

/** A step whose goal is this. */
export function withGoal(step: StepDraft, shape: MessageShape, draft: GoalDraft): StepDraft {
  const others = step.refused.filter(({ path }) => !isAt(path, GOAL));
  const refused = draft.refused.map(({ path, detail }) => ({ path: `${GOAL}.${path}`, detail }));
  return { ...step, goal: { shape, draft }, refused: [...others, ...refused] };
}

function isAt(path: string, where: string): boolean {
  return path === where || path.startsWith(`${where}.`);
}

/** The errors within a field, in one line; undefined for none. */
export function errorAt(errors: readonly FieldError[], where: string): string | undefined {
  const found = errors.filter(({ path }) => isAt(path, where));
  return found.length === 0 ? undefined : found.map(({ detail }) => detail).join("; ");
}

/** The draft with what the gateway has refused, each at its step. @param fields By paths such as `steps.1.wait.seconds`. */
export function withRefused(draft: Draft, fields: readonly FieldError[]): Draft {
  const steps = refusedSteps(draft.steps, fields);
  return { ...draft, steps, refused: fields.filter(({ path }) => !/^steps\.\d/.test(path)) };
}

/** Steps with what the gateway has refused of each. @param list Where they are in the request. */
export function refusedSteps(steps: readonly StepDraft[], fields: readonly FieldError[], list = "steps") {
  const ofStep = (index: number) =>
    fields.flatMap(({ path, detail }) => {
      const start = `${list}.${index}`;
      return isAt(path, start) ? [{ path: path.slice(start.length + 1), detail }] : [];
    });
  return steps.map((step, index) => ({ ...step, refused: ofStep(index) }));
}
