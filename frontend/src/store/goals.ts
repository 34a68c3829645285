import { type EventOf, type GoalStatus, isFinal, isTerminal, type LiveGoal } from "@dock-gateway/client";
import { withGap, withStage } from "./stages";
import { type GoalsState, MAX_ARRIVALS, MAX_GOALS } from "./state";

/** How a goal goes, without its feedback. */
export type GoalCourse = Omit<LiveGoal, "feedback" | "feedback_count" | "last_event_id">;

/** What feedback changes of a goal, besides `stalled`. `updated_at` counts only for those that have ended. */
const OF_FEEDBACK: ReadonlySet<string> = new Set([
  "feedback",
  "feedback_count",
  "last_event_id",
  "updated_at",
]);

/**
 * Lists goals newest first, and gives the same list for as long as only feedback comes: feedback comes often, and most of
 * what is shown of goals is not about it.
 */
export function courseLister(): (goals: ReadonlyMap<string, LiveGoal>) => readonly GoalCourse[] {
  let listed: ReadonlyMap<string, LiveGoal> = new Map();
  let list: readonly LiveGoal[] = [];
  return (goals) => {
    if (goals === listed) return list;
    const known = new Map(list.map((goal) => [goal.goal_id, goal]));
    const next = newestFirst(goals).map((goal) => {
      const before = known.get(goal.goal_id);
      return before !== undefined && sameCourse(before, goal) ? before : goal;
    });
    listed = goals;
    if (next.length !== list.length || next.some((goal, index) => goal !== list[index])) list = next;
    return list;
  };
}

function sameCourse(before: LiveGoal, after: LiveGoal): boolean {
  if (before === after) return true;
  if (isTerminal(after.status) && before.updated_at !== after.updated_at) return false;
  const keys = Object.keys(after) as (keyof LiveGoal)[];
  return keys.every((key) => OF_FEEDBACK.has(key) || before[key] === after[key]);
}

/** Newest first. */
export function newestFirst(goals: ReadonlyMap<string, LiveGoal>): LiveGoal[] {
  return [...goals.values()].sort((a, b) => Date.parse(b.created_at) - Date.parse(a.created_at));
}

export function applyStatus<S extends GoalsState>(state: S, event: EventOf<"status">): S {
  const { type: _type, id: _id, time: _time, ...summary } = event;
  const known = state.goals.get(event.goal_id);
  if (known && isFinal(known.status) && known.status !== event.status) return state;
  const next = withGoal(state, { feedback: null, result: null, ...known, ...summary });
  return { ...next, stages: withStage(next.stages, event, Date.parse(event.time)) };
}

export function applyFeedback<S extends GoalsState>(state: S, event: EventOf<"feedback">): S {
  const known = state.goals.get(event.goal_id) ?? unknownGoal(event, "executing");
  const next = withGoal(state, {
    ...known,
    feedback: event.feedback,
    feedback_count: known.feedback_count + 1,
    stalled: false,
    updated_at: event.time,
    last_event_id: event.id,
  });
  const times = [...(state.arrivals.get(event.goal_id) ?? []), Date.parse(event.time)].slice(-MAX_ARRIVALS);
  return { ...next, arrivals: new Map(next.arrivals).set(event.goal_id, times) };
}

export function applyResult<S extends GoalsState>(state: S, event: EventOf<"result">): S {
  const known = state.goals.get(event.goal_id) ?? unknownGoal(event, event.status);
  if (isFinal(known.status) && known.status !== event.status) return state;
  return withGoal(state, {
    ...known,
    status: event.status,
    result: event.result,
    error: event.error,
    stalled: false,
    updated_at: event.time,
    finished_at: event.status === "lost" ? known.finished_at : (known.finished_at ?? event.time),
    last_event_id: event.id,
  });
}

/** Takes up goals that came as an answer over HTTP, unless events have brought something newer. */
export function mergeGoals<S extends GoalsState>(state: S, goals: readonly LiveGoal[]): S {
  let next = state;
  for (const goal of goals) {
    const known = next.goals.get(goal.goal_id);
    if (known && isFinal(known.status) && !isFinal(goal.status)) continue;
    if (!known || Date.parse(goal.updated_at) > Date.parse(known.updated_at)) next = withGoal(next, goal);
  }
  return next;
}

/**
 * The snapshot's goals on the page's actions are the truth; ended ones that are older than those it holds are kept.
 *
 * @param actionNames The page's actions; null where it is about all of them.
 * @param goals Those of every action on the graph.
 */
export function snapshotGoals<S extends GoalsState>(
  state: S,
  actionNames: readonly string[] | null,
  goals: readonly LiveGoal[],
): S {
  const ended = [...state.goals.values()].filter((goal) => isFinal(goal.status));
  const ours = [...ended, ...goals].filter((goal) => actionNames?.includes(goal.action_name) ?? true);
  const map = new Map(ours.map((goal) => [goal.goal_id, goal]));
  const next = prune({ ...state, goals: map, arrivals: new Map() });
  const changed = ours.filter((goal) => !isFinal(state.goals.get(goal.goal_id)?.status ?? "pending"));
  const stages = changed.reduce((known, { goal_id }) => withGap(known, goal_id), next.stages);
  return { ...next, stages: ours.reduce((known, goal) => withStage(known, goal, null), stages) };
}

function withGoal<S extends GoalsState>(state: S, goal: LiveGoal): S {
  return prune({ ...state, goals: new Map(state.goals).set(goal.goal_id, goal) });
}

function prune<S extends GoalsState>(state: S): S {
  const arrivals = new Map(
    [...state.arrivals].filter(([id]) => {
      const goal = state.goals.get(id);
      return goal !== undefined && !isTerminal(goal.status);
    }),
  );
  if (state.goals.size <= MAX_GOALS) return { ...state, arrivals };
  const ended = newestFirst(state.goals).filter((goal) => isTerminal(goal.status));
  const goals = new Map(state.goals);
  for (const goal of ended.slice(ended.length - (state.goals.size - MAX_GOALS))) goals.delete(goal.goal_id);
  const stages = new Map([...state.stages].filter(([id]) => goals.has(id)));
  return { ...state, goals, arrivals, stages };
}

/** A goal that is known from one event only. */
function unknownGoal(
  event: { goal_id: string; action_name: string; time: string },
  status: GoalStatus,
): LiveGoal {
  return {
    goal_id: event.goal_id,
    action_name: event.action_name,
    action_type: "",
    verb: null,
    status,
    stalled: false,
    stage: null,
    retries: null,
    origin: "external",
    goal: null,
    feedback: null,
    result: null,
    error: null,
    created_at: event.time,
    updated_at: event.time,
    finished_at: null,
    feedback_count: 0,
    last_event_id: null,
  };
}
