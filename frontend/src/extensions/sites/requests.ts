import { deadline, type Http, settle } from "@dock-gateway/client";
import type { Client } from "openapi-fetch";
import { atServer } from "../../api/site";

/** A site as its hub knows it. */
export interface Site {
  name: string;
  state: "connected" | "unreachable" | "refused";
  /** When it got into that state. */
  changed_at: string;
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
  /** `pending`: a stop that the site has not confirmed, and that the hub sends again. */
  stop: { latched: boolean; robots: string[]; pending?: PendingStop | null };
  /** How many of its messages were refused, by code. */
  refused: Record<string, number>;
  /** Why that was, the last time. */
  detail: string | null;
}

export interface PendingStop {
  robots: string[];
  by: string | null;
  stopped_at: string;
}

interface OneSite {
  parameters: { path: { site: string } };
  responses: { 204: { content: Record<never, never> } };
}

/** What became of a stop at a site. */
export interface SiteStop {
  stopped: boolean;
  warning: string | null;
  /** Why it is not confirmed. */
  detail: string | null;
  /** Whether the hub sends it again until it is confirmed or released. */
  repeated: boolean;
}

export type SiteStops = Record<string, SiteStop>;

interface StopAnswer {
  sites: SiteStops;
}

/** The routes that only a hub has: they are not in the OpenAPI document of a gateway. */
interface HubPaths {
  "/sites": { get: { responses: { 200: { content: { "application/json": { sites: Site[] } } } } } };
  "/sites/{site}": { delete: OneSite };
  "/stop": {
    post: {
      parameters: { query?: { robot?: string[] } };
      requestBody: { content: { "application/json": { by: string } } };
      responses: {
        200: { content: { "application/json": StopAnswer } };
        504: { content: { "application/problem+json": StopAnswer } };
      };
    };
    delete: {
      parameters: { query: { robot: string } };
      responses: { 200: { content: { "application/json": object } } };
    };
  };
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

/** Stops robots of sites, all of every site for none; by site. That one was not reached is no failure of the request. */
export async function stopSites(http: Http, by: string, robots: readonly string[]): Promise<SiteStops> {
  const request = atHub(http).POST("/stop", {
    body: { by },
    params: { query: { robot: [...robots] } },
    signal: deadline(),
    ...atServer(),
  });
  const answer = request.then(({ data, error, response }) =>
    error !== undefined && "sites" in error
      ? { data: error, response: new Response(null) }
      : { data, error, response },
  );
  return (await settle<StopAnswer>(answer as Promise<{ data: StopAnswer; response: Response }>)).sites;
}

/** Releases the stop of a robot, of all of a site for `/berlin`. Throws a ClientError where it was not released. */
export async function releaseSites(http: Http, robot: string): Promise<void> {
  await settle(atHub(http).DELETE("/stop", { params: { query: { robot } }, signal: deadline() }));
}
