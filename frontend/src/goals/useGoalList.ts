import type { GoalPage, ListedGoal, LiveGoal } from "@dock-gateway/client";
import { useEffect, useMemo, useRef } from "react";
import { createGoalsApi } from "../api/goals";
import { useFleet, useFleetLive, useFleetTopic, useNaming } from "../fleet/context";
import { type PagedList, usePages } from "../ui/requests";
import { isEmpty } from "../ui/timeRange";
import { useZone } from "../ui/zone";
import { type GoalFilter, goalFilter, matches, toQuery } from "./filter";

const REFETCH_MS = 10_000;
const NO_GOALS: GoalPage = { goals: [], next_cursor: null };

export interface GoalList extends Omit<PagedList<GoalPage>, "pages"> {
  /** Newest first; null until the first page has come. */
  goals: readonly ListedGoal[] | null;
}

/** The goals that fit: what the gateway lists, kept up to date by the stream of all robots. */
export function useGoalList(filter: GoalFilter): GoalList {
  const { http, store } = useFleet();
  const zone = useZone();
  const api = useMemo(() => createGoalsApi(http), [http]);
  const { pages, ...list } = usePages<GoalPage, string>({
    queryKey: ["goals", zone, goalFilter.write(filter).toString()],
    queryFn: async (cursor) => {
      const now = store.gatewayNow();
      return isEmpty(filter.time, now) ? NO_GOALS : api.list(toQuery(filter, now), cursor);
    },
    keepPrevious: true,
    // The stream does not tell of tags. All pages are asked for again, the more the less often.
    refetchMs: (count) => REFETCH_MS * count,
  });
  useAgainWhenBack(list.refetch);
  const known = useKnownGoals(filter.group);
  const goals = useMemo(() => {
    if (pages === undefined) return null;
    const now = store.gatewayNow();
    return mergeGoalList(pages, known, (goal) => matches(goal, filter, now));
  }, [pages, known, filter, store]);
  return { ...list, goals };
}

/** The goals that the stream tells of; of the robots in a group alone, unless it is null. */
function useKnownGoals(group: string | null): readonly LiveGoal[] {
  const goals = useFleetTopic("goals");
  const naming = useNaming();
  return useMemo(() => {
    const known = [...goals.values()];
    if (group === null) return known;
    return known.filter(({ action_name }) => naming.isActionOf(action_name, group));
  }, [goals, naming, group]);
}

/** The stream does not repeat everything that was missed while the gateway was away. */
function useAgainWhenBack(refetch: () => void): void {
  const live = useFleetLive();
  const wasLive = useRef(live);
  useEffect(() => {
    if (live && !wasLive.current) refetch();
    wasLive.current = live;
  }, [live, refetch]);
}

/**
 * The goals of the pages that are loaded, as they are by now, and those that came since; newest first. What the stream
 * knows of older goals than the pages reach is left out, because others are missing between.
 *
 * @param known What the stream tells of goals; they may be newer or older than the pages.
 * @param matches Whether a goal belongs into the list.
 */
export function mergeGoalList(
  pages: readonly GoalPage[],
  known: Iterable<LiveGoal>,
  matches: (goal: ListedGoal) => boolean,
): ListedGoal[] {
  const goals = new Map<string, ListedGoal>(
    pages.flatMap((page) => page.goals.map((goal) => [goal.goal_id, goal])),
  );
  const reach = reachOf(pages);
  for (const goal of known) {
    const listed = goals.get(goal.goal_id);
    if (listed === undefined ? timeOf(goal) >= reach : isNewer(goal, listed)) {
      goals.set(goal.goal_id, listed === undefined ? goal : renewed(listed, goal));
    }
  }
  return [...goals.values()]
    .filter(matches)
    .sort((a, b) => timeOf(b) - timeOf(a) || compare(b.goal_id, a.goal_id));
}

/** When the oldest goal that is loaded was created (ms): everything since is known. */
function reachOf(pages: readonly GoalPage[]): number {
  const last = pages.at(-1);
  const oldest = last?.goals.at(-1);
  if (last?.next_cursor == null || oldest === undefined) return Number.NEGATIVE_INFINITY;
  return timeOf(oldest);
}

function isNewer(goal: LiveGoal, listed: LiveGoal): boolean {
  return Date.parse(goal.updated_at) >= Date.parse(listed.updated_at);
}

/** A goal that the stream knows of one event alone has no type, and not the time when it was created. */
function renewed(listed: ListedGoal, goal: LiveGoal): ListedGoal {
  if (goal.action_type !== "") return { ...listed, ...goal };
  const { status, error, stalled, updated_at, finished_at, feedback, result } = goal;
  return { ...listed, status, error, stalled, updated_at, finished_at, feedback, result };
}

function timeOf(goal: LiveGoal): number {
  return Date.parse(goal.created_at);
}

function compare(a: string, b: string): number {
  return a < b ? -1 : a > b ? 1 : 0;
}
