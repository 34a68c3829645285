import type { GoalStatus } from "@dock-gateway/client";
import { Anchor, Text } from "@mantine/core";
import { Link } from "react-router";
import { fixed } from "../../ui/numbers";
import type { GoalCounts } from "./requests";

/** The states in which goals end, the best first. */
export const ENDS = ["succeeded", "canceled", "aborted", "rejected", "lost"] as const;

interface CountLinkProps {
  counts: GoalCounts;
  statuses: readonly (typeof ENDS)[number][];
}

export const NOT_CANCELED = ENDS.filter((status) => status !== "canceled");
export const SUCCEEDED: readonly GoalStatus[] = ["succeeded"];

/** How many goals ended in these states. */
export function CountLink({ counts, statuses }: CountLinkProps) {
  const count = statuses.reduce((sum, status) => sum + counts.statuses[status], 0);
  return (
    <NumberLink
      text={fixed(count, 0)}
      to={count === 0 ? null : goalsLink(counts, statuses)}
      label={statuses.length === 1 ? `${statuses[0]} goals` : "goals that ended"}
    />
  );
}

export function RateLink({ counts }: { counts: GoalCounts }) {
  const { success_rate } = counts;
  return (
    <NumberLink
      text={percent(success_rate)}
      to={success_rate === null ? null : goalsLink(counts, NOT_CANCELED)}
      label="goals that ended and were not canceled"
    />
  );
}

interface DurationLinkProps {
  counts: GoalCounts;
  of: keyof GoalCounts["duration_s"];
  unit?: string;
}

export function DurationLink({ counts, of, unit = "" }: DurationLinkProps) {
  const seconds = counts.duration_s[of];
  return (
    <NumberLink
      text={tenths(seconds, unit)}
      to={seconds === null ? null : goalsLink(counts, SUCCEEDED)}
      label="succeeded goals"
    />
  );
}

interface NumberLinkProps {
  text: string;
  /** The page that lists the goals behind the number; null where there are none. */
  to: string | null;
  /** What a screen reader says besides: which goals they are. */
  label: string;
}

/** A number that leads to its goals. */
export function NumberLink({ text, to, label }: NumberLinkProps) {
  if (to === null) {
    return (
      <Text span inherit c="dimmed">
        {text}
      </Text>
    );
  }
  return (
    <Anchor component={Link} to={to} inherit aria-label={`${text}: ${label}`}>
      {text}
    </Anchor>
  );
}

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
  ...errors: readonly string[]
): string {
  const more = new URLSearchParams(statuses.map((status) => ["status", status]));
  for (const error of errors) more.append("error", error);
  return `/ui${goals_path}&${more}`;
}
