import type { Http, LiveGoal } from "@dock-gateway/client";
import {
  createContext,
  useCallback,
  useContext,
  useEffect,
  useMemo,
  useState,
  useSyncExternalStore,
} from "react";
import { createGoalsApi, type GoalsApi } from "../api/goals";
import { useFleet } from "../fleet/context";
import { type Entry, timelineOf } from "../goal/timeline";
import { openStream, streamUrl } from "../stream/stream";
import { Crosshair } from "../ui/crosshair";
import { GoalWatch, type Past, type WatchTopics } from "./watch";

/** The goal of a page, and what can be asked of goals. */
interface Watched {
  watch: GoalWatch;
  api: GoalsApi;
  /** In seconds since the goal began. */
  crosshair: Crosshair;
}

export const WatchedContext = createContext<Watched | null>(null);

/** Follows a goal for as long as the page is shown. */
export function useGoalWatch(goalId: string): Watched | null {
  const { http } = useFleet();
  const [watched, setWatched] = useState<Watched | null>(null);
  useEffect(() => {
    const opened = watchGoal(http, goalId);
    setWatched(opened);
    return () => opened.watch.close();
  }, [http, goalId]);
  // For one render after the address has changed it is still the goal before.
  return watched?.watch.goalId === goalId ? watched : null;
}

function watchGoal(http: Http, goalId: string): Watched {
  const api = createGoalsApi(http);
  const watch = new GoalWatch(goalId, api, (handlers) =>
    openStream(streamUrl(window.location, { goal_id: goalId }), handlers),
  );
  void watch.open();
  return { watch, api, crosshair: new Crosshair() };
}

export function useWatched(): Watched {
  const watched = useContext(WatchedContext);
  if (watched === null) throw new Error("WatchedContext is missing");
  return watched;
}

/** A topic of the goal of this page; re-renders when it changes, at most five times a second. */
export function useWatchTopic<T extends keyof WatchTopics>(topic: T): WatchTopics[T] {
  const { watch } = useWatched();
  const subscribe = useCallback((listener: () => void) => watch.subscribe(topic, listener), [watch, topic]);
  return useSyncExternalStore(subscribe, () => watch.get(topic));
}

/** The moment that is marked (s since the goal began). */
export function useMoment(): number | null {
  const { crosshair } = useWatched();
  return useSyncExternalStore(crosshair.subscribe, () => crosshair.moment);
}

/** The moment that the replay stands at (s since the goal began). */
export function useHeldMoment(): number | null {
  const { crosshair } = useWatched();
  return useSyncExternalStore(crosshair.subscribe, () => crosshair.held);
}

/** What a goal went through; the same list until that changes, whatever feedback comes. */
export function useTimeline(goal: LiveGoal): { entries: readonly Entry[]; past: Past } {
  const statuses = useWatchTopic("statuses");
  const past = useWatchTopic("past");
  const complete = past.complete === true;
  const { status, stage, retries, stalled, finished_at, error } = goal;
  // biome-ignore lint/correctness/useExhaustiveDependencies: only these fields of the goal count
  const entries = useMemo(
    () => timelineOf(goal, statuses, complete),
    [status, stage, retries, stalled, finished_at, error, statuses, complete],
  );
  return { entries, past };
}
