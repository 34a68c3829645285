import type { Client } from "openapi-fetch";
import type { Alert } from "../fleet/types";
import { deadline, type Http, settle } from "./http";

interface Acknowledgement {
  parameters: { path: { alert_id: string } };
  responses: { 200: { content: { "application/json": Alert } } };
}

interface AlertPaths {
  "/alerts/{alert_id}/acknowledgement": {
    put: Acknowledgement & { requestBody: { content: { "application/json": { by: string } } } };
    delete: Acknowledgement;
  };
}

/** What can be done about alerts; each call is one request, and every failure a CommandError. */
export interface Alerts {
  /** Says that somebody has seen it, until it ends. */
  acknowledge(id: string, by: string): Promise<Alert>;
  withdraw(id: string): Promise<Alert>;
}

export function createAlerts(http: Http): Alerts {
  const client = http as unknown as Client<AlertPaths>;
  const options = (id: string) => ({ params: { path: { alert_id: id } }, signal: deadline() });
  return {
    acknowledge: (id, by) =>
      settle(client.PUT("/alerts/{alert_id}/acknowledgement", { body: { by }, ...options(id) })),
    withdraw: (id) => settle(client.DELETE("/alerts/{alert_id}/acknowledgement", options(id))),
  };
}
