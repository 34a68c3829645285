import { LIMITS } from "../../api/limits.gen";
import { ALL_ROBOTS, choiceBody, choiceError, type RobotChoice } from "../../fleet/robotChoice";
import { type TimesOfDay, timesBody, timesErrors, timesOf } from "../../ui/timesOfDay";
import type { Rule, RuleBody, RuleMode } from "./requests";

/** In percent: as small as the form takes. */
export const MIN_BELOW = 0.1;
const LIMITS_OF_RULE = LIMITS["PUT /automation/rules/{rule_id}"];
export const { maxLength: MAX_NAME } = LIMITS_OF_RULE.name;
export const { minimum: MIN_IDLE_S, maximum: MAX_IDLE_S } = LIMITS_OF_RULE["battery.idle_s"];
export const MAX_BELOW = 100 * LIMITS_OF_RULE["battery.below"].maximum;
export const { maxItems: MAX_TIMES } = LIMITS_OF_RULE["schedule.times"];

/** A rule as it is typed. */
export interface Draft extends RobotChoice, TimesOfDay {
  name: string;
  condition: "battery" | "schedule";
  /** In percent. */
  below: number | string;
  idleSeconds: number | string;
}

export function draftOf(rule: Rule | null): Draft {
  return {
    name: rule?.name ?? "",
    ...(rule?.robots ?? ALL_ROBOTS),
    condition: rule?.schedule ? "schedule" : "battery",
    below: Math.round((rule?.battery?.below ?? 0.2) * 1000) / 10,
    idleSeconds: rule?.battery?.idle_s ?? 60,
    ...timesOf(rule?.schedule),
  };
}

/** Rules to start from. */
export const EXAMPLES: readonly { label: string; draft: Partial<Draft> }[] = [
  { label: "Dock below 20 %", draft: { name: "Low battery", condition: "battery", below: 20 } },
  { label: "Dock every night at 22:00", draft: { name: "Night", condition: "schedule", times: ["22:00"] } },
];

export type DraftErrors = Partial<Record<keyof Draft, string>>;

/** What is wrong with each field. */
export function errorsOf(draft: Draft): DraftErrors {
  const errors: DraftErrors = {};
  if (draft.name.trim() === "") errors.name = "Type a name.";
  const wrong = choiceError(draft);
  if (wrong !== undefined) errors.names = wrong;
  if (draft.condition === "battery") {
    if (!isWithin(draft.below, MIN_BELOW, MAX_BELOW)) errors.below = "From 0.1 to 100 %";
    if (!isWithin(draft.idleSeconds, MIN_IDLE_S, MAX_IDLE_S)) errors.idleSeconds = "From 10 s to one day";
    return errors;
  }
  return { ...errors, ...timesErrors(draft) };
}

function isWithin(value: number | string, lowest: number, highest: number): boolean {
  return typeof value === "number" && value >= lowest && value <= highest;
}

/** The request that stores a rule. */
export function bodyOf(draft: Draft, mode: RuleMode, by: string | null): RuleBody {
  const robots = choiceBody(draft);
  const condition =
    draft.condition === "battery"
      ? { battery: { below: Math.round(Number(draft.below) * 10) / 1000, idle_s: Number(draft.idleSeconds) } }
      : { schedule: timesBody(draft) as NonNullable<RuleBody["schedule"]> };
  return { name: draft.name.trim(), mode, robots, ...condition, by };
}

/** The request that stores a rule as it is, with another mode. */
export function withMode(
  { name, robots, battery, schedule }: Rule,
  mode: RuleMode,
  by: string | null,
): RuleBody {
  return { name, mode, robots, battery, schedule, by };
}
