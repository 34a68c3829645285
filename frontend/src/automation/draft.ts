import type { Rule, RuleBody, RuleMode } from "../api/automation";
import { zoneName } from "../ui/zone";
import { WEEKDAYS } from "./words";

/** As the gateway allows. */
export const MAX_NAME = 60;
export const MIN_IDLE_S = 10;
export const MAX_IDLE_S = 86_400;
export const MAX_TIMES = 24;
const MAX_ID = 40;
const TIME = /^([01]?\d|2[0-3]):[0-5]\d$/;

/** A rule as it is typed. */
export interface Draft {
  name: string;
  all: boolean;
  names: string[];
  groups: string[];
  condition: "battery" | "schedule";
  /** In percent. */
  below: number | string;
  idleSeconds: number | string;
  times: string[];
  weekdays: string[];
  timeZone: string;
}

export function draftOf(rule: Rule | null): Draft {
  return {
    name: rule?.name ?? "",
    all: rule?.robots.all ?? true,
    names: rule?.robots.names ?? [],
    groups: rule?.robots.groups ?? [],
    condition: rule?.schedule ? "schedule" : "battery",
    below: Math.round((rule?.battery?.below ?? 0.2) * 1000) / 10,
    idleSeconds: rule?.battery?.idle_s ?? 60,
    times: rule?.schedule?.times ?? ["22:00"],
    weekdays: rule?.schedule?.weekdays ?? [...WEEKDAYS],
    timeZone: rule?.schedule?.time_zone ?? zoneName(),
  };
}

export type DraftErrors = Partial<Record<keyof Draft, string>>;

/** What is wrong with each field. */
export function errorsOf(draft: Draft): DraftErrors {
  const errors: DraftErrors = {};
  if (draft.name.trim() === "") errors.name = "Type a name.";
  if (!draft.all && draft.names.length + draft.groups.length === 0)
    errors.names = "Choose a robot or a group.";
  if (draft.condition === "battery") {
    if (!isWithin(draft.below, 0.1, 100)) errors.below = "From 0.1 to 100 %";
    if (!isWithin(draft.idleSeconds, MIN_IDLE_S, MAX_IDLE_S)) errors.idleSeconds = "From 10 s to one day";
    return errors;
  }
  if (draft.times.length === 0) errors.times = "Add a time, such as 22:00.";
  else if (!draft.times.every((time) => TIME.test(time))) errors.times = "Times are from 00:00 to 23:59.";
  if (draft.weekdays.length === 0) errors.weekdays = "Choose a day.";
  return errors;
}

function isWithin(value: number | string, lowest: number, highest: number): boolean {
  return typeof value === "number" && value >= lowest && value <= highest;
}

/** The request that stores a rule. */
export function bodyOf(draft: Draft, mode: RuleMode, by: string | null): RuleBody {
  const robots = draft.all ? { all: true } : { names: draft.names, groups: draft.groups };
  const schedule = { times: draft.times.map(padded), weekdays: draft.weekdays, time_zone: draft.timeZone };
  const condition =
    draft.condition === "battery"
      ? { battery: { below: Math.round(Number(draft.below) * 10) / 1000, idle_s: Number(draft.idleSeconds) } }
      : { schedule: schedule as NonNullable<RuleBody["schedule"]> };
  return { name: draft.name.trim(), mode, robots, ...condition, by };
}

function padded(time: string): string {
  return time.padStart(5, "0");
}

/** The request that stores a rule as it is, with another mode. */
export function withMode(
  { name, robots, battery, schedule }: Rule,
  mode: RuleMode,
  by: string | null,
): RuleBody {
  return { name, mode, robots, battery, schedule, by };
}

/** An id for a new rule: its name in small letters and digits, and a number where that is taken. */
export function newId(name: string, taken: readonly string[]): string {
  const plain = name
    .normalize("NFKD")
    .replace(/\p{M}/gu, "")
    .toLowerCase()
    .replace(/[^a-z0-9]+/g, "-");
  const slug = plain.slice(0, MAX_ID - 4).replace(/^-+|-+$/g, "") || "rule";
  let id = slug;
  for (let number = 2; taken.includes(id); number++) id = `${slug}-${number}`;
  return id;
}
