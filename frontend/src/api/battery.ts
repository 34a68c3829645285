import { type Http, settle } from "./http";
import type { BatteryHistory } from "./types";

/** A span of the past that takes this long to read is too long to wait for. */
const TIMEOUT_MS = 12_000;

/**
 * What was measured from `since` on and before `until` (ms), at so many points at most.
 *
 * @param robot Its namespace; null for the one that the gateway is configured for.
 * @param signal Ends the request where nobody wants the answer any more.
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
      signal: AbortSignal.any([signal, AbortSignal.timeout(TIMEOUT_MS)]),
    }),
  );
}
