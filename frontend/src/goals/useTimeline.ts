import { useMemo } from "react";
import type { AnyGoal } from "../api/types";
import { type Entry, timelineOf } from "../goal/timeline";
import { useWatchTopic } from "./useGoalWatch";
import type { Past } from "./watch";

/** What a goal went through; the same list until that changes, whatever feedback comes. */
export function useTimeline(goal: AnyGoal): { entries: readonly Entry[]; past: Past } {
  const statuses = useWatchTopic("statuses");
  const past = useWatchTopic("past");
  const complete = past.complete === true;
  const { status, stage, retries, stalled, finished_at, error } = goal;
  // biome-ignore lint/correctness/useExhaustiveDependencies: what of the goal is told
  const entries = useMemo(
    () => timelineOf(goal, statuses, complete),
    [status, stage, retries, stalled, finished_at, error, statuses, complete],
  );
  return { entries, past };
}
