import { type BatteryHistory, type Http, settle } from "@dock-gateway/client";

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
