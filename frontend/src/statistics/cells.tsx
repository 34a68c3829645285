import { Anchor, Text } from "@mantine/core";
import { Link } from "react-router";
import type { GoalCounts, GoalStatus } from "../api/types";
import { fixed } from "../ui/numbers";
import { ENDS, goalsLink, percent, tenths } from "./words";

interface CountLinkProps {
  counts: GoalCounts;
  statuses: readonly (typeof ENDS)[number][];
}

const NOT_CANCELED = ENDS.filter((status) => status !== "canceled");
const SUCCEEDED: readonly GoalStatus[] = ["succeeded"];

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
