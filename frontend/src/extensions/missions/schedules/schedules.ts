import { clockOf, dayOf, formatDuration, formatTime, timeAt } from "../../../ui/time";
import { dayWords, type TimesOfDay, timesBody, timesErrors, timesOf, WEEKDAYS } from "../../../ui/timesOfDay";
import type { StepDraft } from "../draft";
import { named, type Stored, sorted, useStored } from "../stored";
import type { Taker } from "../TakerField";
import { argumentsOf, missingIn, type NamedTemplate, stepsTrouble, textOf } from "../templates/templates";
import { plain, stepsFrom, stepsOf } from "../written";
import { deleteSchedule, listSchedules, putSchedule, type Schedule, type ScheduleBody } from "./requests";

export type NamedSchedule = Schedule & { name: string };

export const SCHEDULES: Stored<NamedSchedule, ScheduleBody> = {
  key: ["schedules"],
  list: async (http) => sorted((await listSchedules(http)).map(named)),
  put: async (http, id, body, base) => named(await putSchedule(http, id, body, base)),
  remove: deleteSchedule,
};

/** How often it is asked what came of schedules, and what others have changed (ms). */
const REFETCH_MS = 5000;

/** The schedules, by name. */
export function useSchedules() {
  return useStored(SCHEDULES, REFETCH_MS);
}

/** `Every day at 06:00, 22:00 (Europe/Berlin)`, `Every 1 h 30 min`, `Once, 1 Dec 06:00` */
export function whenWords({ once, daily, every }: Pick<Schedule, "once" | "daily" | "every">): string {
  if (once !== null) return `Once, ${formatTime(Date.parse(once.due_at))}`;
  if (every !== null) return `Every ${formatDuration(every.minutes * 60_000)}`;
  if (daily === null) return "";
  const days =
    daily.weekdays.length === WEEKDAYS.length ? "Every day" : daily.weekdays.map(dayWords).join(", ");
  return `${days} at ${daily.times.join(", ")} (${daily.time_zone})`;
}

/** `Fetch (shelf: shelf-a3)`, `3 steps` */
export function missionWords({ mission }: Schedule, templates: readonly NamedTemplate[]): string {
  const { template, steps, arguments: given } = mission;
  if (template === null) return steps?.length === 1 ? "One step" : `${steps?.length ?? 0} steps`;
  const name = templates.find(({ id }) => id === template)?.name ?? template;
  const words = Object.entries(given ?? {}).map(([key, value]) => `${key}: ${textOf(value)}`);
  return words.length === 0 ? name : `${name} (${words.join(", ")})`;
}

const CODES: Record<string, string> = {
  still_running: "Skipped: its last mission had not ended",
  schedule_missed: "Missed: no gateway ran within an hour",
  template_not_found: "Its template was removed",
  robot_not_found: "The robot was not there",
  limit_reached: "Too many missions wait already",
};

/** Why the last time queued no mission; null where it did. */
export function failureWords({ last }: Pick<Schedule, "last">): string | null {
  if (last === null || last.code === null) return null;
  return CODES[last.code] ?? last.detail ?? last.code;
}

type When = "once" | "daily" | "every";

/** A schedule as it is typed. */
export interface ScheduleDraft extends TimesOfDay, Taker {
  name: string;
  /** The id of a template; empty for steps. */
  template: string;
  typed: Record<string, string>;
  steps: readonly StepDraft[];
  /** What else its missions have. */
  kept: Pick<Schedule["mission"], "name" | "priority" | "battery">;
  when: When;
  day: string;
  clock: string;
  minutes: number | string;
  queues: boolean;
}

/** @param now In the gateway's time (ms). */
export function draftOf(schedule: NamedSchedule | null, robot: string, now: number): ScheduleDraft {
  const { once, daily, every, mission } = schedule ?? {};
  const at = once == null ? now + 3_600_000 : Date.parse(once.due_at);
  const given = Object.entries(mission?.arguments ?? {}).map(([key, value]) => [key, textOf(value)]);
  return {
    name: schedule?.name ?? "",
    robot: schedule?.robot ?? robot,
    group: schedule?.group ?? null,
    template: mission?.template ?? "",
    typed: Object.fromEntries(given) as Record<string, string>,
    steps: stepsFrom(plain(mission?.steps ?? [{ undock: {} }, { dock: {} }]) as unknown[], now),
    kept: {
      name: mission?.name ?? null,
      priority: mission?.priority ?? null,
      battery: mission?.battery ?? null,
    },
    when: once != null ? "once" : every != null ? "every" : "daily",
    day: dayOf(at),
    clock: clockOf(at),
    ...timesOf(daily),
    minutes: every?.minutes ?? 60,
    queues: schedule?.if_running === "queue",
  };
}

const A_WEEK = 10_080;

/** What is wrong with each field. */
export function errorsOf(draft: ScheduleDraft, templates: readonly NamedTemplate[]) {
  const errors: Partial<Record<keyof ScheduleDraft, string>> = {};
  if (draft.name.trim() === "") errors.name = "Type a name.";
  const template = templates.find(({ id }) => id === draft.template);
  if (draft.template === "") {
    const trouble = stepsTrouble(draft.steps);
    if (trouble !== null) errors.steps = trouble;
  } else if (template === undefined) errors.template = "This template was removed.";
  else if (missingIn(template, draft.typed).length > 0) errors.typed = "A parameter needs a value.";
  if (draft.when === "once" && timeAt(draft.day, draft.clock) === null)
    errors.day = "A day and a time, such as 06:00";
  if (draft.when === "daily") Object.assign(errors, timesErrors(draft));
  const { minutes } = draft;
  if (
    draft.when === "every" &&
    !(Number.isInteger(minutes) && Number(minutes) >= 1 && Number(minutes) <= A_WEEK)
  )
    errors.minutes = "From 1 minute to a week";
  return errors;
}

/** @param enabled Whether it is on. */
export function bodyOf(
  draft: ScheduleDraft,
  templates: readonly NamedTemplate[],
  enabled: boolean,
  by: string | null,
): ScheduleBody {
  const template = templates.find(({ id }) => id === draft.template);
  const mission =
    template === undefined
      ? { ...draft.kept, steps: stepsOf(draft.steps) }
      : { ...draft.kept, template: template.id, arguments: argumentsOf(template, draft.typed) };
  const when = {
    once: { once: { due_at: new Date(timeAt(draft.day, draft.clock) ?? 0).toISOString() } },
    daily: { daily: timesBody(draft) },
    every: { every: { minutes: Number(draft.minutes) } },
  }[draft.when];
  const if_running = draft.queues ? "queue" : "skip";
  return {
    name: draft.name.trim(),
    ...(draft.group === null ? { robot: draft.robot } : { group: draft.group }),
    enabled,
    mission,
    ...when,
    if_running,
    by,
  } as ScheduleBody;
}

/** The request that stores a schedule as it is, on or off. */
export function withEnabled(schedule: NamedSchedule, enabled: boolean, by: string | null): ScheduleBody {
  const { name, robot, group, mission, once, daily, every, if_running } = schedule;
  return { name, robot, group, mission, once, daily, every, if_running, enabled, by } as ScheduleBody;
}
