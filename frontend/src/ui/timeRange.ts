import type { Part } from "./address";
import { dayOf, startOfDay } from "./time";

/** How far back, in the words of its choice. */
export const LASTS = { today: "Today", "24h": "24 h", "7d": "7 d", "30d": "30 d" } as const;
export type Last = keyof typeof LASTS;

/** Days, of which today is the last. */
const DAYS: Partial<Record<Last, number>> = { today: 1, "7d": 7, "30d": 30 };

/** A part of time as it stands in an address. */
export interface TimeRange {
  /** If set, `since` and `until` are ignored. */
  last: Last | null;
  /** RFC 3339. */
  since: string | null;
  until: string | null;
}

export const ANY_TIME: TimeRange = { last: null, since: null, until: null };

/** As it stands in an address. @param initial What it is without. */
export function timeRange(initial = ANY_TIME): Part<TimeRange> {
  return {
    read: (parameters) => {
      const last = parameters.get("last");
      if (last !== null && last in LASTS) return { ...ANY_TIME, last: last as Last };
      const [since, until] = ["since", "until"].map((name) => readTime(parameters.get(name)));
      return since || until ? { last: null, since: since ?? null, until: until ?? null } : initial;
    },
    write: ({ last, since, until }, parameters) => {
      if (last !== null && last !== initial.last) parameters.set("last", last);
      if (last === null && since !== null) parameters.set("since", since);
      if (last === null && until !== null) parameters.set("until", until);
    },
  };
}

/** From `since` up to but not including `until` (ms); null is without an end. @param now In the gateway's time (ms). */
export function boundsOf(
  { last, since, until }: TimeRange,
  now: number,
): { since: number | null; until: number | null } {
  if (last === "24h") return { since: now - 86_400_000, until: null };
  if (last !== null) return { since: startOfDay(dayOf(now, 1 - (DAYS[last] ?? 1))), until: null };
  return {
    since: since === null ? null : Date.parse(since),
    until: until === null ? null : Date.parse(until),
  };
}

/** Whether it ends before it begins, as while one of its dates is typed: nothing is in it. */
export function isEmpty(range: TimeRange, now: number): boolean {
  const { since, until } = boundsOf(range, now);
  return since !== null && until !== null && until <= since;
}

/** The query parameters of a request about this time. */
export function timeQuery(range: TimeRange, now: number): { since?: string; until?: string } {
  const { since, until } = boundsOf(range, now);
  return {
    ...(since === null ? {} : { since: new Date(since).toISOString() }),
    ...(until === null ? {} : { until: new Date(until).toISOString() }),
  };
}

/** Dates to begin with: those that a range has been until now, to the end of today. */
export function ownDates(range: TimeRange, now: number): TimeRange {
  const since = boundsOf(range, now).since ?? startOfDay(dayOf(now));
  const whole = startOfDay(dayOf(since));
  return {
    last: null,
    since: new Date(whole).toISOString(),
    until: new Date(startOfDay(dayOf(now), 1)).toISOString(),
  };
}

function readTime(text: string | null): string | null {
  return text === null || Number.isNaN(Date.parse(text)) ? null : text;
}
