import type { StatisticsQuery } from "../api/statistics";

export const RANGES = { today: "Today", "7d": "7 days", "30d": "30 days", own: "Dates" } as const;
export type Range = keyof typeof RANGES;
export const GROUPINGS = { day: "Day", robot: "Robot", action: "Action" } as const;
export type Grouping = keyof typeof GROUPINGS;

/** What the page shows; lives in its address. */
export interface View {
  range: Range;
  /** Days such as `2026-11-22`, both included; set where the range is `own`. */
  from: string | null;
  to: string | null;
  by: Grouping;
  /** A namespace: goals on actions in it or below; null for all. */
  robot: string | null;
}

export const DEFAULT_VIEW: View = { range: "7d", from: null, to: null, by: "day", robot: null };

/** The view in an address; what it does not understand is replaced by the default. */
export function readView(parameters: URLSearchParams): View {
  const range = parameters.get("range") ?? "";
  const by = parameters.get("by") ?? "";
  const [from = null, to = from] = [parameters.get("from"), parameters.get("to")].filter(isDay).sort();
  const own = range === "own" && from !== null;
  return {
    range: own ? "own" : range in RANGES && range !== "own" ? (range as Range) : DEFAULT_VIEW.range,
    from: own ? from : null,
    to: own ? to : null,
    by: by in GROUPINGS ? (by as Grouping) : DEFAULT_VIEW.by,
    robot: parameters.get("robot") || null,
  };
}

export function writeView(view: View): URLSearchParams {
  const parameters = new URLSearchParams();
  if (view.range !== DEFAULT_VIEW.range) parameters.set("range", view.range);
  if (view.from !== null) parameters.set("from", view.from);
  if (view.to !== null) parameters.set("to", view.to);
  if (view.by !== DEFAULT_VIEW.by) parameters.set("by", view.by);
  if (view.robot !== null) parameters.set("robot", view.robot);
  return parameters;
}

/** Another range; own dates begin with those that are shown. @param now In the gateway's time (ms). */
export function withRange(view: View, range: Range, now: number): View {
  if (range !== "own") return { ...view, range, from: null, to: null };
  return { ...view, range, from: dayOf(now, 1 - (DAYS[view.range] ?? 1)), to: dayOf(now, 0) };
}

const DAYS: Partial<Record<Range, number>> = { today: 1, "7d": 7, "30d": 30 };

/** @param now In the gateway's time (ms). */
export function toQuery({ range, from, to, by, robot }: View, now: number): StatisticsQuery {
  const since = range === "own" ? from : dayOf(now, 1 - (DAYS[range] ?? 1));
  return {
    by,
    tz: timeZone(),
    ...(robot === null ? {} : { robot }),
    ...(since === null ? {} : { since: midnight(since, 0) }),
    ...(to === null ? {} : { until: midnight(to, 1) }),
  };
}

/** Days in an answer by day. */
export const MAX_DAYS = 400;

/** Whether own dates are more days than the gateway tells one by one. */
export function isTooLong({ by, from, to }: View): boolean {
  if (by !== "day" || from === null || to === null) return false;
  return (Date.parse(to) - Date.parse(from)) / 86_400_000 >= MAX_DAYS;
}

/** The reader's time zone. */
export function timeZone(): string {
  const zone = Intl.DateTimeFormat().resolvedOptions().timeZone;
  return zone === undefined || zone === "Etc/Unknown" ? "UTC" : zone;
}

/** A day in the reader's zone, some days after that of a time. */
export function dayOf(ms: number, later: number): string {
  const date = new Date(ms);
  date.setDate(date.getDate() + later);
  const two = (value: number) => String(value).padStart(2, "0");
  return `${date.getFullYear()}-${two(date.getMonth() + 1)}-${two(date.getDate())}`;
}

/** When a day begins in the reader's zone, or one some days later (RFC 3339). */
function midnight(day: string, later: number): string {
  const date = new Date(`${day}T00:00:00`);
  date.setDate(date.getDate() + later);
  return date.toISOString();
}

function isDay(text: string | null): text is string {
  return (
    text !== null &&
    /^(19[7-9]|2[01]\d)\d-\d\d-\d\d$/.test(text) &&
    !Number.isNaN(Date.parse(`${text}T00:00:00`))
  );
}
