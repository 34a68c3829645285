import { outgoing } from "../../actions/form/draft";
import { timeAt } from "../../ui/time";
import { type BatteryDraft, type Draft, isBlock, isInterruptible, type StepDraft } from "./draft";
import type { Mission } from "./requests";

/** When a robot returns to charge, as it is sent. */
export function limitsOf(battery: BatteryDraft | null): Mission["battery"] {
  return battery && { below: chargeOf(battery.below), charge_to: chargeOf(battery.chargeTo) };
}

/** 0 to 1. */
function chargeOf(percent: number | string): number {
  return Math.round(Number(percent) * 10) / 1000;
}

/** The request that starts a mission: JSON, as goals are written, so that no number in them is rounded. */
export function bodyOf({ group, name, priority, battery, steps }: Draft, by: string | null): string {
  const limits = limitsOf(battery);
  const fields = { name: name.trim() || null, priority: Number(priority), by };
  const own = { ...fields, ...(limits && { battery: limits }) };
  const head = JSON.stringify(group === null ? own : { ...own, group });
  return `${head.slice(0, -1)},"steps":[${steps.map(stepText).join(",")}]}`;
}

/** The request of a step: JSON. */
export function stepText(step: StepDraft): string {
  if (step.kind === "json") return step.content;
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
