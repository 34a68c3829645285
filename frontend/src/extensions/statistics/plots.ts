import { codeWords } from "../../goal/words";
import { fixed } from "../../ui/numbers";
import { dayWords, ENDS, goalsLink, NOT_CANCELED, percent, SUCCEEDED, tenths } from "./cells";
import type { GoalCounts, GoalGroup } from "./requests";

/** The number of errors that have a colour of their own; the rest is `Other`. */
export const MAX_KINDS = 5;

/** A day's point or bar, which leads to the goals that it counts. */
export interface Mark {
  key: string;
  /** Which day, from 0. */
  column: number;
  /** The lower end of the bar on the vertical axis; `to` is the upper one. */
  from: number;
  to: number;
  /** The point inside of it, such as a median; null for a bar. */
  at: number | null;
  /** Which kind of bar, from 0; -1 is `Other`. */
  kind: number;
  path: string;
  label: string;
}

/** A bar a day: the share of the succeeded goals, with that of the failed ones above. */
export function rateMarks(days: readonly GoalGroup[]): Mark[] {
  return days.flatMap((day, column) => {
    const rate = day.success_rate;
    if (rate === null) return [];
    const counted = day.ended - day.statuses.canceled;
    return {
      key: day.key,
      column,
      from: 0,
      to: rate,
      at: null,
      kind: 0,
      path: goalsLink(day, NOT_CANCELED),
      label: `${dayWords(day.key)}: ${percent(rate)}, ${day.statuses.succeeded} of ${goalsWords(counted)}`,
    };
  });
}

/** A day's median, with the span that eight of ten goals are in. */
export function durationMarks(days: readonly GoalGroup[]): Mark[] {
  return days.flatMap((day, column) => {
    const { p10, median, p90 } = day.duration_s;
    if (p10 === null || median === null || p90 === null) return [];
    return {
      key: day.key,
      column,
      from: p10,
      to: p90,
      at: median,
      kind: 0,
      path: goalsLink(day, SUCCEEDED),
      label: `${dayWords(day.key)}: median ${tenths(median, " s")} (${tenths(p10)} to ${tenths(p90)}), ${goalsWords(day.statuses.succeeded)}`,
    };
  });
}

/** The error codes that have a colour, the most frequent first. */
export function kindsOf(total: GoalCounts): string[] {
  return total.errors.slice(0, MAX_KINDS).map(({ code }) => code);
}

/** Bars on each other: how many goals of a day had each error. */
export function errorMarks(days: readonly GoalGroup[], kinds: readonly string[]): Mark[] {
  return days.flatMap((day, column) => {
    let height = 0;
    const marks: Mark[] = [];
    const add = (kind: number, words: string, count: number, path: string) => {
      if (count === 0) return;
      const label = `${dayWords(day.key)}: ${words}, ${goalsWords(count)}`;
      marks.push({
        key: `${day.key} ${words}`,
        column,
        from: height,
        to: height + count,
        at: null,
        kind,
        path,
        label,
      });
      height += count;
    };
    for (const [kind, code] of kinds.entries()) {
      const count = day.errors.find((error) => error.code === code)?.count ?? 0;
      add(kind, codeWords(code), count, goalsLink(day, ENDS, code));
    }
    const rest = day.errors.filter(({ code }) => !kinds.includes(code));
    const others = rest.reduce((sum, { count }) => sum + count, day.other_errors);
    // The codes beyond those that the gateway lists have no names to filter by.
    const codes = day.other_errors > 0 ? [] : rest.map(({ code }) => code);
    add(-1, "Other errors", others, goalsLink(day, ENDS, ...codes));
    return marks;
  });
}

export function goalsWords(count: number): string {
  return count === 1 ? "1 goal" : `${fixed(count, 0)} goals`;
}

/** Two to five round numbers from 0 on, of which the last is not below the maximum; `whole` for counts. */
export function roundTicks(max: number, whole = false): number[] {
  if (!(max > 0)) return [0, 1];
  const rough = max / 4;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 2.5, 5, 10].map((each) => each * power).find((each) => each >= rough) ?? rough;
  const used = whole ? Math.max(1, Math.ceil(step)) : step;
  return Array.from({ length: Math.ceil(max / used - 1e-9) + 1 }, (_, index) => index * used);
}
