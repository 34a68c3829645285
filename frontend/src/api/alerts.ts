import { deadline, type Http, settle } from "./http";
import type { Alert } from "./types";

/** What can be done about alerts; each call is one request, and every failure a CommandError. */
export interface Alerts {
  /** Says that somebody has seen it, until it ends. */
  acknowledge(id: string, by: string): Promise<Alert>;
  withdraw(id: string): Promise<Alert>;
}

export function createAlerts(http: Http): Alerts {
  const options = (id: string) => ({ params: { path: { alert_id: id } }, signal: deadline() });
  return {
    acknowledge: (id, by) =>
      settle(http.PUT("/alerts/{alert_id}/acknowledgement", { body: { by }, ...options(id) })),
    withdraw: (id) => settle(http.DELETE("/alerts/{alert_id}/acknowledgement", options(id))),
  };
}
