import { isFinal, isTerminal, type LiveGoal } from "@dock-gateway/client";
import { Skeleton, Stack, Text } from "@mantine/core";
import { useGatewayNow } from "../clock/clock";
import { useFleetLive } from "../fleet/context";
import { GoalStatusBadge } from "../goal/facts";
import { stageName, stageWords } from "../goal/stages";
import type { Entry } from "../goal/timeline";
import { entryAt } from "../goal/timeline";
import { meaning } from "../goal/words";
import { Trouble } from "../ui/errors";
import { Section } from "../ui/Section";
import { Time } from "../ui/Time";
import { sentence } from "../ui/text";
import { formatDuration } from "../ui/time";
import classes from "./goalPage.module.css";
import { useMoment, useTimeline, useWatched } from "./useGoalWatch";

/** What a goal went through: its statuses and stages, when they began and how long they lasted. */
export function GoalTimeline({ goal }: { goal: LiveGoal }) {
  const { watch } = useWatched();
  const { entries, past } = useTimeline(goal);
  const moment = useMoment();
  const waiting = past.loading && past.complete === null;
  const marked = moment === null ? -1 : entryAt(entries, Date.parse(goal.created_at) + moment * 1000);
  return (
    <Section title="Timeline">
      <Trouble
        what="What came before could not be loaded"
        error={past.error}
        onRetry={() => void watch.readPast()}
      />
      {past.complete === false && (
        <Text size="sm" c="dimmed">
          The history no longer reaches back to the beginning of this goal.
        </Text>
      )}
      {waiting ? (
        <TimelineSkeleton />
      ) : (
        <ol className={classes.timeline} data-testid="timeline">
          {entries.map((entry, index) => (
            <TimelineEntry
              key={entry.key}
              entry={entry}
              goal={goal}
              last={index === entries.length - 1}
              marked={index === marked}
            />
          ))}
        </ol>
      )}
    </Section>
  );
}

interface TimelineEntryProps {
  entry: Entry;
  goal: LiveGoal;
  last: boolean;
  /** Whether the goal was there at the moment that is marked. */
  marked: boolean;
}

function TimelineEntry({ entry, goal, last, marked }: TimelineEntryProps) {
  const { change, time, lasted } = entry;
  const goesOn = last && !isFinal(goal.status);
  return (
    <li
      className={classes.entry}
      data-tone={toneOf(change, goesOn)}
      data-marked={marked || undefined}
      aria-current={goesOn ? "step" : undefined}
    >
      <div className={classes.entryHead}>
        <Text component="div" size="sm" fw={600}>
          {change.kind === "status" ? <GoalStatusBadge status={change.status} /> : titleOf(change)}
        </Text>
        <span className={classes.when}>
          {time === null ? "since an unknown time" : <Time value={time} />}
          {lasted !== null && `, for ${lastedWords(lasted)}`}
          {goesOn && time !== null && <SoFar since={time} />}
        </span>
      </div>
      <Text size="sm" c="dimmed">
        {wordsOf(change, goal)}
      </Text>
    </li>
  );
}

function lastedWords(ms: number): string {
  return ms < 100 ? `${Math.round(ms)} ms` : formatDuration(ms);
}

function SoFar({ since }: { since: number }) {
  const now = useGatewayNow();
  return useFleetLive() ? `, for ${formatDuration(now - since)} so far` : ", not live";
}

type Change = Entry["change"];

function titleOf(change: Exclude<Change, { kind: "status" }>): string {
  if (change.kind === "silence") return change.silent ? "Stalled" : "Answers again";
  return change.stage === "RETRY" ? `Retry ${change.retries || ""}` : stageName(change.stage);
}

function wordsOf(change: Change, { verb }: LiveGoal): string {
  if (change.kind === "silence") {
    return change.silent ? "The action server is not responding." : "The action server is responding again.";
  }
  if (change.kind === "stage") return stageWords(change.stage) ?? "";
  const { status, error } = change;
  const meant = meaning({ verb, status, error, stalled: false, stage: null });
  if (error === null) return meant;
  return status === "canceled"
    ? `${meant} ${sentence(error.detail)}.`
    : `${sentence(error.detail)} (${error.code})`;
}

/** Stages that come of a failure. */
const RECOVERING: ReadonlySet<string> = new Set(["RETRY", "CORRECTING", "RETURN_TO_STAGING"]);

function toneOf(change: Change, goesOn: boolean): string | undefined {
  if (change.kind === "silence") return change.silent ? "warn" : undefined;
  if (change.kind === "stage") return RECOVERING.has(change.stage) ? "warn" : goesOn ? "now" : undefined;
  if (change.status === "succeeded") return "good";
  if (change.status === "canceled") return undefined;
  if (change.status === "lost") return "unknown";
  if (change.status === "canceling") return "warn";
  if (isTerminal(change.status)) return "bad";
  return goesOn ? "now" : undefined;
}

function TimelineSkeleton() {
  return (
    <Stack gap="md">
      <Skeleton height={44} />
      <Skeleton height={44} />
      <Skeleton height={44} />
    </Stack>
  );
}
