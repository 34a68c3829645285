import type { GoalStatus, ListedGoal, LiveGoal } from "@dock-gateway/client";
import type { GoalQuery } from "../api/goals";
import { isBelow } from "../fleet/names";
import { Address, oneOf, optional, text, texts } from "../ui/address";
import { boundsOf, type TimeRange, timeQuery, timeRange } from "../ui/timeRange";

/** The states that people tell apart; `running` are those before the end. */
export const STATES = ["running", "succeeded", "canceled", "aborted", "rejected", "lost"] as const;
export type GoalState = (typeof STATES)[number];

const RUNNING: readonly GoalStatus[] = ["pending", "accepted", "executing", "canceling"];

export type Origin = LiveGoal["origin"];
const ORIGINS: readonly Origin[] = ["gateway", "automation", "external"];

/** Which goals to list; lives in the page's address. */
export interface GoalFilter {
  time: TimeRange;
  /** A namespace: goals on actions in it or below. */
  robot: string | null;
  /** Goals of the robots that are in it now; null for all. */
  group: string | null;
  /** None is all. */
  actions: readonly string[];
  /** None is all. */
  states: readonly GoalState[];
  /** Error codes; none is all, with and without an error. */
  errors: readonly string[];
  origin: Origin | null;
  /** The beginning of the id; empty is any. */
  id: string;
  /** None is all, with and without tags. */
  tags: readonly string[];
}

/** The beginnings of an id that `GET /goals` accepts. */
export const ID_BEGINNING = /^(?:[0-9a-f]-?){4,32}$/i;

export const goalFilter = new Address<GoalFilter>({
  robot: optional("robot"),
  group: optional("group"),
  actions: texts("action"),
  states: {
    // Any status before the end counts as running.
    read: (parameters) => {
      const told = parameters.getAll("status").map((status) => stateOf(status as GoalStatus) as string);
      return STATES.filter((state) => told.includes(state));
    },
    write: texts("status").write,
  },
  errors: texts("error"),
  origin: oneOf("origin", ORIGINS, null),
  time: timeRange(),
  id: text("id", ID_BEGINNING),
  tags: texts("tag"),
});

/** Where the goals are listed that fit. */
export function goalsPath(filter: Partial<GoalFilter>): string {
  return `/ui/goals?${goalFilter.write({ ...goalFilter.initial, ...filter })}`;
}

/** @param now In the gateway's time (ms). */
export function toQuery(filter: GoalFilter, now: number): GoalQuery {
  return {
    ...(filter.robot === null ? {} : { robot: filter.robot }),
    ...(filter.group === null ? {} : { group: filter.group }),
    ...(filter.actions.length === 0 ? {} : { action: [...filter.actions] }),
    ...(filter.states.length === 0 ? {} : { status: filter.states.flatMap(statusesOf) }),
    ...(filter.errors.length === 0 ? {} : { error: [...filter.errors] }),
    ...(filter.origin === null ? {} : { origin: filter.origin }),
    ...timeQuery(filter.time, now),
    ...(filter.id === "" ? {} : { id: filter.id }),
    ...(filter.tags.length === 0 ? {} : { tag: [...filter.tags] }),
  };
}

/** Whether `GET /goals` would list it, too; but for the group, which the gateway knows best. */
export function matches(goal: ListedGoal, filter: GoalFilter, now: number): boolean {
  const { since, until } = boundsOf(filter.time, now);
  const created = Date.parse(goal.created_at);
  return (
    (filter.robot === null || isBelow(goal.action_name, filter.robot)) &&
    (filter.actions.length === 0 || filter.actions.includes(goal.action_name)) &&
    (filter.states.length === 0 || filter.states.includes(stateOf(goal.status))) &&
    (filter.errors.length === 0 || (goal.error !== null && filter.errors.includes(goal.error.code))) &&
    (filter.origin === null || goal.origin === filter.origin) &&
    (since === null || created >= since) &&
    (until === null || created < until) &&
    digitsOf(goal.goal_id).startsWith(digitsOf(filter.id)) &&
    (filter.tags.length === 0 || filter.tags.some((tag) => goal.tags?.includes(tag)))
  );
}

function stateOf(status: GoalStatus): GoalState {
  return RUNNING.includes(status) ? "running" : (status as GoalState);
}

function statusesOf(state: GoalState): readonly GoalStatus[] {
  return state === "running" ? RUNNING : [state];
}

/** The digits of an id, which may be written without hyphens and in upper case. */
function digitsOf(id: string): string {
  return id.replaceAll("-", "").toLowerCase();
}
