import {
  type BatteryHistory,
  type components,
  deadline,
  type Http,
  type paths,
  type Statistics,
  settle,
} from "@dock-gateway/client";
import { apiPath } from "./site";

/** One request or command, as it was recorded. */
export type AuditRecord = components["schemas"]["AuditRecord"];
export type AuditPage = components["schemas"]["AuditPage"];
/** What `GET /audit` can be narrowed by. */
export type AuditQuery = Omit<NonNullable<paths["/audit"]["get"]["parameters"]["query"]>, "limit" | "cursor">;

const PAGE = 50;

/** Newest first. Every failure is a ClientError. */
export function listAudit(http: Http, query: AuditQuery, cursor: number | null): Promise<AuditPage> {
  return settle(
    http.GET("/audit", {
      params: { query: { ...query, limit: PAGE, ...(cursor === null ? {} : { cursor }) } },
      signal: deadline(),
    }),
  );
}

/** Where the records that a list is narrowed to are downloaded. */
export function auditExportUrl(query: AuditQuery, format: "csv" | "json"): string {
  const parameters = new URLSearchParams({ format });
  for (const [name, value] of Object.entries(query)) parameters.set(name, String(value));
  return apiPath(`/audit/export?${parameters}`);
}

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

/** A span of the past that takes this long to read is too long to wait for. */
const BATTERY_TIMEOUT_MS = 12_000;

/**
 * What was measured from `since` on and before `until` (ms), at `points` points at most.
 *
 * @param robot Its namespace; null for the one that the gateway is configured for.
 * @param signal Ends the request when its answer is no longer needed.
 */
export function batteryHistory(
  http: Http,
  robot: string | null,
  span: { since: number; until: number; points: number },
  signal: AbortSignal,
): Promise<BatteryHistory> {
  const query = {
    ...(robot === null ? {} : { robot }),
    since: new Date(span.since).toISOString(),
    until: new Date(span.until).toISOString(),
    points: span.points,
  };
  return settle(
    http.GET("/battery/history", {
      params: { query },
      signal: AbortSignal.any([signal, AbortSignal.timeout(BATTERY_TIMEOUT_MS)]),
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
