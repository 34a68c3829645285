import type { StatisticsQuery } from "../api/history";
import { dayOf } from "../ui/time";
import { readTimeRange, type TimeRange, timeQuery, writeTimeRange } from "../ui/timeRange";
import { zoneName } from "../ui/zone";

export const GROUPINGS = { day: "Day", robot: "Robot", action: "Action" } as const;
export type Grouping = keyof typeof GROUPINGS;

/** What the page shows; lives in its address. */
export interface View {
  time: TimeRange;
  by: Grouping;
  /** A namespace: goals on actions in it or below; null for all. */
  robot: string | null;
  /** Goals of the robots that are in it now; null for all. */
  group: string | null;
  /** Goals with one of these; none is all, with and without tags. */
  tags: readonly string[];
}

const DEFAULT_VIEW: View = {
  time: { last: "7d", since: null, until: null },
  by: "day",
  robot: null,
  group: null,
  tags: [],
};

/** The view in an address; what it does not understand is replaced by the default. */
export function readView(parameters: URLSearchParams): View {
  const by = parameters.get("by") ?? "";
  const time = readTimeRange(parameters);
  const { last, since, until } = time;
  return {
    time: last === null && since === null && until === null ? DEFAULT_VIEW.time : time,
    by: by in GROUPINGS ? (by as Grouping) : DEFAULT_VIEW.by,
    robot: parameters.get("robot") || null,
    group: parameters.get("group") || null,
    tags: parameters.getAll("tag").filter((tag) => tag !== ""),
  };
}

export function writeView({ time, by, robot, group, tags }: View): URLSearchParams {
  const parameters = new URLSearchParams();
  if (time.last !== DEFAULT_VIEW.time.last) writeTimeRange(time, parameters);
  if (by !== DEFAULT_VIEW.by) parameters.set("by", by);
  if (robot !== null) parameters.set("robot", robot);
  if (group !== null) parameters.set("group", group);
  for (const tag of tags) parameters.append("tag", tag);
  return parameters;
}

/** @param now In the gateway's time (ms). */
export function toQuery({ time, by, robot, group, tags }: View, now: number): StatisticsQuery {
  return {
    by,
    tz: zoneName(),
    ...(robot === null ? {} : { robot }),
    ...(group === null ? {} : { group }),
    ...(tags.length === 0 ? {} : { tag: [...tags] }),
    ...timeQuery(time, now),
  };
}

/** Days in an answer by day. */
export const MAX_DAYS = 400;

/** Whether these are more days than the gateway tells one by one. @param now In the gateway's time (ms). */
export function isTooLong({ by, time: { since, until } }: View, now: number): boolean {
  if (by !== "day" || since === null) return false;
  const last = dayOf((until === null ? now : Date.parse(until)) - 1);
  return (Date.parse(last) - Date.parse(dayOf(Date.parse(since)))) / 86_400_000 >= MAX_DAYS;
}
