import { isObject, type Json, type JsonObject } from "../../api/jsonSchema";
import { newStep, type StepDraft } from "./draft";
import { stepOf } from "./fromMission";
import type { MissionStep } from "./requests";
import { usedIn } from "./templates/parameters";
import { stepText } from "./toRequest";

/** What a text says as JSON; undefined if it is none. */
export function parsed(text: string): Json | undefined {
  try {
    return JSON.parse(text) as Json;
  } catch {
    return undefined;
  }
}

/**
 * Steps as they are put together, from those that are written in JSON: one that the fields of a step cannot show as it is,
 * for instance as a number in it is a parameter, is left as JSON.
 */
export function stepsFrom(written: readonly unknown[], now: number): StepDraft[] {
  return written.map((each) => stepFrom(each, now));
}

export function stepFrom(written: unknown, now: number): StepDraft {
  const draft = isObject(written) ? read(written, now) : null;
  const again = draft === null ? undefined : parsed(stepText(draft));
  return draft !== null && again !== undefined && isSame(plain(written), plain(again))
    ? draft
    : newStep("json", now, { content: JSON.stringify(written, null, 1) });
}

/** The steps that a draft says, without those that are no JSON. */
export function stepsOf(drafts: readonly StepDraft[]): unknown[] {
  return drafts.flatMap((draft) => {
    const written = parsed(stepText(draft));
    return written === undefined ? [] : [tidy(written)];
  });
}

/** The same step, written in JSON; null where it is not complete. */
export function asJson(step: StepDraft): StepDraft | null {
  const written = parsed(stepText(step));
  if (written === undefined) return null;
  return { ...step, kind: "json", content: JSON.stringify(tidy(written), null, 1), refused: [] };
}

/** The same step with its fields; null where those cannot show it. */
export function asFields(step: StepDraft, now: number): StepDraft | null {
  const draft = stepFrom(parsed(step.content), now);
  return draft.kind === "json" ? null : { ...draft, key: step.key };
}

/** What a step has that says nothing of it. */
const NOTHING = {
  ...{ dock: null, undock: null, navigate: null, action: null, call: null, publish: null, notify: null },
  ...{ wait: null, repeat: null, first_that_works: null, name: null, timeout_s: null },
  ...{ tries: 1, on_failure: "end", interruptible: false },
};
const DEFAULTS: Record<string, JsonObject> = {
  navigate: { place: null, pose: null, poses: null },
  wait: { seconds: null, until: null, battery: null, person: false },
  call: { type: null, request: {} },
  publish: { type: null, message: {} },
  notify: { critical: false },
};

/** Null where a step is none that fields can show. */
function read(written: JsonObject, now: number): StepDraft | null {
  const { repeat, first_that_works, action } = written;
  if (isObject(action) && usedIn(action.goal).length > 0) return null;
  const fields = Object.entries({ ...NOTHING, ...written }).map(([name, value]) => [
    name,
    isObject(value) ? Object.assign({}, DEFAULTS[name], value) : value,
  ]);
  const step = Object.fromEntries(fields) as unknown as MissionStep;
  try {
    if (isObject(repeat))
      return {
        ...stepOf({ ...step, repeat: { times: (repeat.times ?? null) as number | null, round: 0 } }, [], now),
        content: JSON.stringify(repeat.steps, null, 1),
      };
    if (first_that_works !== undefined && first_that_works !== null)
      return {
        ...stepOf({ ...step, first_that_works: { alternatives: 0 } }, [], now),
        content: JSON.stringify(first_that_works, null, 1),
      };
    return stepOf(step, [], now);
  } catch {
    return null;
  }
}

/** A step without options that are as they are by default. */
function tidy(written: Json): unknown {
  if (!isObject(written)) return written;
  return Object.fromEntries(
    Object.entries(written).filter(
      ([name, value]) => !(name === "tries" && value === 1) && !(name === "on_failure" && value === "end"),
    ),
  );
}

/** A value without the fields that say nothing. */
export function plain(value: unknown): unknown {
  if (Array.isArray(value)) return value.map(plain);
  if (!isObject(value)) return value;
  const said = Object.entries(value).filter(
    ([name, item]) =>
      item !== null &&
      item !== false &&
      !(name === "tries" && item === 1) &&
      !(name === "on_failure" && item === "end") &&
      !(name === "yaw" && item === 0) &&
      !(name === "frame" && item === "map"),
  );
  return Object.fromEntries(said.map(([name, item]) => [name, plain(item)]));
}

/** Radians that were degrees in between are not the same to the last digit. */
const ROUNDING = 1e-4;

function isSame(one: unknown, other: unknown): boolean {
  if (typeof one === "number" && typeof other === "number") return Math.abs(one - other) <= ROUNDING;
  if (Array.isArray(one) && Array.isArray(other))
    return one.length === other.length && one.every((each, index) => isSame(each, other[index]));
  if (!isObject(one) || !isObject(other)) return one === other;
  const names = Object.keys(one);
  return names.length === Object.keys(other).length && names.every((name) => isSame(one[name], other[name]));
}
