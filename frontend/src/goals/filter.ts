import type { GoalQuery } from "../api/goals";
import type { AnyGoal, GoalStatus, ListedGoal } from "../api/types";

/** The states that people tell apart; `running` are those before the end. */
export const STATES = ["running", "succeeded", "canceled", "aborted", "rejected", "lost"] as const;
export type GoalState = (typeof STATES)[number];

const RUNNING: readonly GoalStatus[] = ["pending", "accepted", "executing", "canceling"];

/** How far back a list goes, in ms. */
export const SPANS = { "1h": 3_600_000, "24h": 86_400_000, "7d": 604_800_000 } as const;
export type Span = keyof typeof SPANS;

export type Origin = AnyGoal["origin"];

/** Which goals to list; lives in the page's address. */
export interface GoalFilter {
  /** A namespace: goals on actions in it or below. */
  robot: string | null;
  /** None is all. */
  actions: readonly string[];
  /** None is all. */
  states: readonly GoalState[];
  /** Error codes; none is all, with and without an error. */
  errors: readonly string[];
  origin: Origin | null;
  /** Goes before `since` and `until`. */
  last: Span | null;
  /** RFC 3339. */
  since: string | null;
  until: string | null;
  /** The beginning of the id; empty is any. */
  id: string;
  /** None is all, with and without tags. */
  tags: readonly string[];
}

/** As `GET /goals` takes the beginning of an id. */
export const ID_BEGINNING = /^(?:[0-9a-f]-?){4,32}$/i;

export const NO_FILTER: GoalFilter = {
  robot: null,
  actions: [],
  states: [],
  errors: [],
  origin: null,
  last: null,
  since: null,
  until: null,
  id: "",
  tags: [],
};

/** The filter in an address; what it does not understand is left out. Any state before the end counts as running. */
export function readFilter(parameters: URLSearchParams): GoalFilter {
  const told = parameters.getAll("status").map((status) => stateOf(status as GoalStatus) as string);
  const origin = parameters.get("origin");
  const last = parameters.get("last");
  return {
    robot: parameters.get("robot") || null,
    actions: parameters.getAll("action").filter((name) => name !== ""),
    states: STATES.filter((state) => told.includes(state)),
    errors: parameters.getAll("error").filter((code) => code !== ""),
    origin: origin === "gateway" || origin === "external" ? origin : null,
    last: last !== null && last in SPANS ? (last as Span) : null,
    since: readTime(parameters.get("since")),
    until: readTime(parameters.get("until")),
    id: ID_BEGINNING.test(parameters.get("id") ?? "") ? (parameters.get("id") ?? "") : "",
    tags: parameters.getAll("tag").filter((tag) => tag !== ""),
  };
}

export function writeFilter(filter: GoalFilter): URLSearchParams {
  const parameters = new URLSearchParams();
  if (filter.robot !== null) parameters.set("robot", filter.robot);
  for (const action of filter.actions) parameters.append("action", action);
  for (const state of filter.states) parameters.append("status", state);
  for (const code of filter.errors) parameters.append("error", code);
  if (filter.origin !== null) parameters.set("origin", filter.origin);
  if (filter.last !== null) parameters.set("last", filter.last);
  else {
    if (filter.since !== null) parameters.set("since", filter.since);
    if (filter.until !== null) parameters.set("until", filter.until);
  }
  if (filter.id !== "") parameters.set("id", filter.id);
  for (const tag of filter.tags) parameters.append("tag", tag);
  return parameters;
}

export function isFiltered(filter: GoalFilter): boolean {
  return writeFilter(filter).size > 0;
}

/** @param now In the gateway's time (ms). */
export function toQuery(filter: GoalFilter, now: number): GoalQuery {
  const { since, until } = timesOf(filter, now);
  return {
    ...(filter.robot === null ? {} : { robot: filter.robot }),
    ...(filter.actions.length === 0 ? {} : { action: [...filter.actions] }),
    ...(filter.states.length === 0 ? {} : { status: filter.states.flatMap(statusesOf) }),
    ...(filter.errors.length === 0 ? {} : { error: [...filter.errors] }),
    ...(filter.origin === null ? {} : { origin: filter.origin }),
    ...(since === null ? {} : { since: new Date(since).toISOString() }),
    ...(until === null ? {} : { until: new Date(until).toISOString() }),
    ...(filter.id === "" ? {} : { id: filter.id }),
    ...(filter.tags.length === 0 ? {} : { tag: [...filter.tags] }),
  };
}

/** Whether `GET /goals` would list it, too. */
export function matches(goal: ListedGoal, filter: GoalFilter, now: number): boolean {
  const { since, until } = timesOf(filter, now);
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

export function stateOf(status: GoalStatus): GoalState {
  return RUNNING.includes(status) ? "running" : (status as GoalState);
}

function statusesOf(state: GoalState): readonly GoalStatus[] {
  return state === "running" ? RUNNING : [state];
}

/** Of an id, which may be written without its hyphens and in upper case. */
function digitsOf(id: string): string {
  return id.replaceAll("-", "").toLowerCase();
}

function isBelow(name: string, namespace: string): boolean {
  return name.startsWith(namespace === "/" ? "/" : `${namespace}/`);
}

function timesOf(
  { last, since, until }: GoalFilter,
  now: number,
): { since: number | null; until: number | null } {
  if (last !== null) return { since: now - SPANS[last], until: null };
  return {
    since: since === null ? null : Date.parse(since),
    until: until === null ? null : Date.parse(until),
  };
}

function readTime(text: string | null): string | null {
  return text === null || Number.isNaN(Date.parse(text)) ? null : text;
}
