import type { GoalCounts, GoalStatus } from "../api/types";
import { fixed } from "../ui/numbers";

/** The states in which goals end, the best first. */
export const ENDS = ["succeeded", "canceled", "aborted", "rejected", "lost"] as const;

/** A share in percent. What is not all does not read 100.0 %. */
export function percent(share: number | null): string {
  if (share === null) return "–";
  return `${fixed(share < 1 ? Math.min(99.9, 100 * share) : 100, 1)} %`;
}

/** Seconds or a count, with one decimal. */
export function tenths(value: number | null, unit = ""): string {
  return value === null ? "–" : `${fixed(value, 1)}${unit}`;
}

const days = new Intl.DateTimeFormat(undefined, {
  weekday: "short",
  day: "2-digit",
  month: "short",
  timeZone: "UTC",
});

/** `2026-11-22` as people write it. */
export function dayWords(day: string): string {
  return days.format(Date.parse(`${day}T12:00:00Z`));
}

/** The page that lists goals of a group. */
export function goalsLink(
  { goals_path }: Pick<GoalCounts, "goals_path">,
  statuses: readonly GoalStatus[],
  error?: string,
): string {
  const more = new URLSearchParams(statuses.map((status) => ["status", status]));
  if (error !== undefined) more.append("error", error);
  return `/ui${goals_path}&${more}`;
}
