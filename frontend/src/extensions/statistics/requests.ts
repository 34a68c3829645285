import { type components, type Http, type paths, settle } from "@dock-gateway/client";

export type Statistics = components["schemas"]["Statistics"];
/** How the goals of a group ended. */
export type GoalCounts = components["schemas"]["GoalCounts"];
export type GoalGroup = components["schemas"]["GoalGroup"];

export type StatisticsQuery = NonNullable<paths["/statistics"]["get"]["parameters"]["query"]>;

/** The gateway gives up on a query after 8 s; another may run before it. */
const STATISTICS_TIMEOUT_MS = 20_000;

/** @param signal Ends the request when its answer is no longer needed. */
export function fetchStatistics(
  http: Http,
  query: StatisticsQuery,
  signal: AbortSignal,
): Promise<Statistics> {
  return settle(
    http.GET("/statistics", {
      params: { query },
      signal: AbortSignal.any([signal, AbortSignal.timeout(STATISTICS_TIMEOUT_MS)]),
    }),
  );
}

/** How long docking takes a robot, in the last seven days and in the seven before. */
export type DockingTrend = components["schemas"]["DockingTrend"];

type DockingTimeQuery = NonNullable<paths["/statistics/docking-time"]["get"]["parameters"]["query"]>;

/** The trends of the robots that have docked in the last fourteen days, by name. */
export async function dockingTimes(
  http: Http,
  query: DockingTimeQuery,
  signal: AbortSignal,
): Promise<DockingTrend[]> {
  const { robots = [] } = await settle(
    http.GET("/statistics/docking-time", {
      params: { query },
      signal: AbortSignal.any([signal, AbortSignal.timeout(STATISTICS_TIMEOUT_MS)]),
    }),
  );
  return robots;
}
