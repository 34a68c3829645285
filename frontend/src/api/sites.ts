import { deadline, type Http, settle } from "@dock-gateway/client";
import type { Client } from "openapi-fetch";

/** A site as its hub knows it. */
export interface Site {
  name: string;
  state: "connected" | "unreachable" | "refused";
  /** When it got into that state. */
  since: string;
  /** Null until it was connected once. */
  version: string | null;
  machine: string;
  /** The age of the newest report. */
  lag_ms: number | null;
  round_trip_ms: number | null;
  /** How far its clock is ahead of the hub's. */
  clock_offset_s: number | null;
  /** Whether the hub still reads what it missed. */
  behind: boolean;
  robots: number;
  goals_running: number;
  alerts: number;
  stop: { latched: boolean; robots: string[] };
  /** How many of its messages were refused, by code. */
  refused: Record<string, number>;
  /** Why that was, the last time. */
  detail: string | null;
}

interface OneSite {
  parameters: { path: { site: string } };
  responses: { 204: { content: Record<never, never> } };
}

/** What only a hub has, beside what the OpenAPI document of a gateway says. */
interface HubPaths {
  "/sites": { get: { responses: { 200: { content: { "application/json": { sites: Site[] } } } } } };
  "/sites/{site}": { delete: OneSite };
}

const atHub = (http: Http) => http as unknown as Client<HubPaths>;

/** Every site that one may see, by name. Every failure is a ClientError. */
export async function listSites(http: Http): Promise<Site[]> {
  return (await settle(atHub(http).GET("/sites", { signal: deadline() }))).sites;
}

/** Forgets a site and whose name it is; its goals stay. */
export async function forgetSite(http: Http, site: string): Promise<void> {
  await settle(atHub(http).DELETE("/sites/{site}", { params: { path: { site } }, signal: deadline() }));
}
