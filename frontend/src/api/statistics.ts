import { type Http, settle } from "./http";
import type { paths } from "./schema.gen";
import type { Statistics } from "./types";

export type StatisticsQuery = NonNullable<paths["/statistics"]["get"]["parameters"]["query"]>;

/** The gateway gives up on a query after 8 s; another may run before it. */
const TIMEOUT_MS = 20_000;

/** @param signal Ends the request when its answer is no longer needed. */
export function fetchStatistics(
  http: Http,
  query: StatisticsQuery,
  signal: AbortSignal,
): Promise<Statistics> {
  return settle(
    http.GET("/statistics", {
      params: { query },
      signal: AbortSignal.any([signal, AbortSignal.timeout(TIMEOUT_MS)]),
    }),
  );
}
