import type { AnyGoal, AnyGoalPage, ListedGoal } from "../api/types";

/**
 * The goals of the pages that are loaded, as they are by now, and those that came since; newest first. What the stream
 * knows of older goals than the pages reach is left out, because others are missing between.
 *
 * @param known What the stream tells of goals; they may be newer or older than the pages.
 * @param matches Whether a goal belongs into the list.
 */
export function mergeGoalList(
  pages: readonly AnyGoalPage[],
  known: Iterable<AnyGoal>,
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
function reachOf(pages: readonly AnyGoalPage[]): number {
  const last = pages.at(-1);
  const oldest = last?.goals.at(-1);
  if (last?.next_cursor == null || oldest === undefined) return Number.NEGATIVE_INFINITY;
  return timeOf(oldest);
}

function isNewer(goal: AnyGoal, listed: AnyGoal): boolean {
  return Date.parse(goal.updated_at) >= Date.parse(listed.updated_at);
}

/** A goal that the stream knows of one event alone has no type, and not the time when it was created. */
function renewed(listed: ListedGoal, goal: AnyGoal): ListedGoal {
  if (goal.action_type !== "") return listed.tags?.length ? { ...goal, tags: listed.tags } : goal;
  const { status, error, stalled, updated_at, finished_at, feedback, result } = goal;
  return { ...listed, status, error, stalled, updated_at, finished_at, feedback, result };
}

function timeOf(goal: AnyGoal): number {
  return Date.parse(goal.created_at);
}

function compare(a: string, b: string): number {
  return a < b ? -1 : a > b ? 1 : 0;
}
