import { keepPreviousData, useInfiniteQuery } from "@tanstack/react-query";
import { useEffect, useMemo, useRef } from "react";
import { type CommandError, toCommandError } from "../api/errors";
import { createGoalsApi } from "../api/goals";
import type { AnyGoal, AnyGoalPage, ListedGoal } from "../api/types";
import { useFleet, useFleetLive, useFleetTopic, useNaming } from "../fleet/context";
import { useZone } from "../ui/zone";
import { type GoalFilter, matches, toQuery, writeFilter } from "./filter";
import { mergeGoalList } from "./list";

const REFETCH_MS = 10_000;

export interface GoalList {
  /** Newest first; null until the first page has come. */
  goals: readonly ListedGoal[] | null;
  error: CommandError | null;
  /** Whether there are older ones. */
  more: boolean;
  loading: boolean;
  loadMore(): void;
  retry(): void;
}

/** The goals that fit: what the gateway lists, kept up to date by the stream of all robots. */
export function useGoalList(filter: GoalFilter): GoalList {
  const { http, store } = useFleet();
  const zone = useZone();
  const api = useMemo(() => createGoalsApi(http), [http]);
  const query = useInfiniteQuery<
    AnyGoalPage,
    CommandError,
    { pages: AnyGoalPage[] },
    readonly string[],
    string | null
  >({
    queryKey: ["goals", zone, writeFilter(filter).toString()],
    queryFn: ({ pageParam }) =>
      api.list(toQuery(filter, store.gatewayNow()), pageParam).catch((error: unknown) => {
        throw toCommandError(error);
      }),
    initialPageParam: null,
    getNextPageParam: (page) => page.next_cursor,
    placeholderData: keepPreviousData,
    // The stream does not tell of tags. All pages are asked for again, the more the less often.
    refetchInterval: ({ state }) => REFETCH_MS * (state.data?.pages.length ?? 1),
  });
  const { data, refetch } = query;
  useAgainWhenBack(refetch);
  const known = useKnownGoals(filter.group);
  const goals = useMemo(() => {
    if (data === undefined) return null;
    const now = store.gatewayNow();
    return mergeGoalList(data.pages, known, (goal) => matches(goal, filter, now));
  }, [data, known, filter, store]);

  return {
    goals,
    error: query.error,
    more: query.hasNextPage && !query.isPlaceholderData,
    loading: query.isFetching,
    loadMore: () => void query.fetchNextPage(),
    retry: () => void refetch(),
  };
}

/** The goals that the stream tells of; of the robots in a group alone, unless it is null. */
function useKnownGoals(group: string | null): readonly AnyGoal[] {
  const goals = useFleetTopic("goals");
  const naming = useNaming();
  return useMemo(() => {
    const known = [...goals.values()];
    if (group === null) return known;
    return known.filter(({ action_name }) => naming.isActionOf(action_name, group));
  }, [goals, naming, group]);
}

/** What was missed while the gateway was away is not all told by the stream. */
function useAgainWhenBack(refetch: () => void): void {
  const live = useFleetLive();
  const wasLive = useRef(live);
  useEffect(() => {
    if (live && !wasLive.current) refetch();
    wasLive.current = live;
  }, [live, refetch]);
}
