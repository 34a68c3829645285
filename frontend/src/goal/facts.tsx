import type { GoalStatus, LiveGoal } from "@dock-gateway/client";
import { Alert, Badge, Text } from "@mantine/core";
import { useAtTime } from "../clock/clock";
import { useFleetLive } from "../fleet/context";
import { fixed } from "../ui/numbers";
import { sentence } from "../ui/text";
import classes from "./goal.module.css";
import { advice, durationWords, type Lifetime, type Meant, meaning, STATUS_COLORS } from "./words";

export function GoalStatusBadge({ status, testId }: { status: GoalStatus; testId?: string }) {
  return (
    <Badge component="span" color={STATUS_COLORS[status]} data-testid={testId}>
      {status}
    </Badge>
  );
}

interface FeedbackCountProps {
  count: number;
  /** When the latest came (ms), oldest first; null for a goal that has ended. */
  arrivals: readonly number[] | null;
}

/** How many feedback messages have come, and how fast they come: a text of its own, which changes with each. */
export function FeedbackCount({ count, arrivals }: FeedbackCountProps) {
  const perSecond = useAtTime((now) => {
    const hz = arrivals === null ? null : rate(arrivals, now);
    return hz === null ? "" : fixed(hz, 1);
  });
  return `${count} ${count === 1 ? "message" : "messages"}${perSecond === "" ? "" : `, ${perSecond} Hz`}`;
}

const WINDOW_MS = 3000;

/** Messages a second over the last three seconds, or null where that is too few to say. */
export function rate(arrivals: readonly number[], now: number): number | null {
  const recent = arrivals.filter((time) => now - time <= WINDOW_MS);
  const [first] = recent;
  const last = recent.at(-1);
  if (first === undefined || last === undefined || last <= first) return null;
  return ((recent.length - 1) * 1000) / (last - first);
}

/** How long a goal took, or has been running for. */
export function GoalDuration({ goal }: { goal: Lifetime }) {
  const words = useAtTime((now) => durationWords(goal, now));
  const live = useFleetLive();
  return live || goal.finished_at !== null ? words : "not live";
}

const ORIGINS: Record<LiveGoal["origin"], { words: string; color: string }> = {
  gateway: { words: "gateway", color: "blue" },
  automation: { words: "automatic", color: "teal" },
  external: { words: "external", color: "grape" },
};

/** Whether a goal was sent through the gateway, by a rule, or by someone else. */
export function OriginBadge({ origin }: Pick<LiveGoal, "origin">) {
  const { words, color } = ORIGINS[origin];
  return (
    <Badge variant="outline" color={color}>
      {words}
    </Badge>
  );
}

/** Why a goal stands as it does: an alert where something is wrong, a quiet line otherwise. A cancel is no failure. */
export function GoalExplanation({ goal }: { goal: Meant }) {
  const { error, stalled, status } = goal;
  const hint = advice(goal);
  if (status === "canceled" || (error === null && !stalled && status !== "lost")) {
    return (
      <div>
        <Text size="sm" c="dimmed">
          {meaning(goal)}
          {error !== null && ` ${sentence(error.detail)}.`}
        </Text>
        {hint !== null && (
          <Text size="sm" c="dimmed">
            {hint}
          </Text>
        )}
      </div>
    );
  }
  return (
    <Alert color={stalled ? "orange" : "red"} title={meaning(goal)}>
      {hint !== null && <Text size="sm">{hint}</Text>}
      {error !== null && (
        <details className={classes.details}>
          <summary>Details</summary>
          <Text size="sm">{sentence(error.detail)}</Text>
          <Text size="sm">Code: {error.code}</Text>
        </details>
      )}
    </Alert>
  );
}
