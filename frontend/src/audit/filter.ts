import type { AuditQuery, AuditRecord } from "../api/audit";
import { ANY_TIME, readTimeRange, type TimeRange, timeQuery, writeTimeRange } from "../ui/timeRange";

export type Outcome = AuditRecord["outcome"];
export const OUTCOMES: readonly Outcome[] = ["done", "refused", "failed"];

/** Which records to list; lives in the page's address. Empty is any. */
export interface AuditFilter extends TimeRange {
  principal: string;
  what: string;
  robot: string;
  goalId: string;
  outcome: Outcome | null;
}

/** As `GET /audit` takes it. */
export const GOAL_ID = /^[0-9a-f]{8}(-?[0-9a-f]{4}){3}-?[0-9a-f]{12}$/i;

export const NO_FILTER: AuditFilter = {
  ...ANY_TIME,
  principal: "",
  what: "",
  robot: "",
  goalId: "",
  outcome: null,
};

/** The filter in an address; what it does not understand is left out. */
export function readFilter(parameters: URLSearchParams): AuditFilter {
  const outcome = parameters.get("outcome");
  const goalId = parameters.get("goal_id") ?? "";
  return {
    ...readTimeRange(parameters),
    principal: parameters.get("principal") ?? "",
    what: parameters.get("what") ?? "",
    robot: parameters.get("robot") ?? "",
    goalId: GOAL_ID.test(goalId) ? goalId : "",
    outcome: OUTCOMES.find((each) => each === outcome) ?? null,
  };
}

export function writeFilter(filter: AuditFilter): URLSearchParams {
  const parameters = new URLSearchParams(named(filter));
  writeTimeRange(filter, parameters);
  return parameters;
}

/** @param now In the gateway's time (ms). */
export function toQuery(filter: AuditFilter, now: number): AuditQuery {
  return { ...named(filter), ...timeQuery(filter, now) };
}

function named({ principal, what, robot, goalId, outcome }: AuditFilter): Record<string, string> {
  const values = { principal, what, robot, goal_id: goalId, outcome: outcome ?? "" };
  return Object.fromEntries(Object.entries(values).filter(([, value]) => value !== ""));
}
