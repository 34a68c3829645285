import { Address, oneOf, optional, texts } from "../../ui/address";
import { dayOf } from "../../ui/time";
import { type TimeRange, timeQuery, timeRange } from "../../ui/timeRange";
import { zoneName } from "../../ui/zone";
import type { StatisticsQuery } from "./requests";

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

const WEEK: TimeRange = { last: "7d", since: null, until: null };

export const statisticsView = new Address<View>({
  time: timeRange(WEEK),
  by: oneOf("by", Object.keys(GROUPINGS) as Grouping[], "day"),
  robot: optional("robot"),
  group: optional("group"),
  tags: texts("tag"),
});

/** @param now In the gateway's time (ms). */
export function toQuery({ time, by, robot, group, tags }: View, now: number): StatisticsQuery {
  return {
    by,
    time_zone: zoneName(),
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
