import { type components, deadline, type Http, newKey, settle } from "@dock-gateway/client";
import { ifUnchanged } from "../../api/version";

type Schemas = components["schemas"];

/** What a robot does, one step after the other. */
export type Mission = Schemas["Mission"];
export type MissionStep = Schemas["MissionStep"];
export type Waypoint = Schemas["Waypoint"];
export type MissionStatus = Schemas["MissionStatus"];
export type Reason = Schemas["Reason"];
export type MissionList = Schemas["MissionList"];

/** What can be done to a mission that has not ended. */
export type Verb = "pause" | "continue" | "skip" | "cancel";

const ENDED: MissionStatus[] = ["succeeded", "failed", "canceled"];
const ENDED_PAGE = 20;

/** A page of the ended ones, newest first. */
export function listEnded(http: Http, cursor: string | null): Promise<MissionList> {
  const query = { status: ENDED, limit: ENDED_PAGE, ...(cursor !== null && { cursor }) };
  return settle(http.GET("/missions", { params: { query }, signal: deadline() }));
}

/** As many as one request may ask for. */
const MOST_LISTED = 500;

/** The ended ones that had not ended before a time (RFC 3339). */
export async function listEndedSince(http: Http, since: string): Promise<Mission[]> {
  const found: Mission[] = [];
  for (let cursor: string | null = null; ; ) {
    const query = { status: ENDED, since, limit: MOST_LISTED, ...(cursor !== null && { cursor }) };
    const page: MissionList = await settle(http.GET("/missions", { params: { query }, signal: deadline() }));
    found.push(...page.missions);
    if (page.next_cursor === null) return found;
    cursor = page.next_cursor;
  }
}

export function getMission(http: Http, id: string): Promise<Mission> {
  return settle(
    http.GET("/missions/{mission_id}", { params: { path: { mission_id: id } }, signal: deadline() }),
  );
}

/**
 * @param robot Null where the body says of which group it is.
 * @param body The mission as JSON, sent as it is: goals may have numbers that are rounded otherwise.
 */
export function createMission(http: Http, robot: string | null, body: string): Promise<Mission> {
  return settle(
    http.POST("/missions", {
      params: { query: robot === null ? {} : { robot } },
      headers: { "Idempotency-Key": newKey() },
      body: { steps: [] },
      bodySerializer: () => body,
      signal: deadline(),
    }),
  );
}

/**
 * Replaces what a mission is to do that has not begun.
 *
 * @param base The mission as it was read: if it has changed since, the gateway refuses.
 * @param body As for `createMission`.
 */
export function replaceMission(http: Http, base: Mission, body: string): Promise<Mission> {
  return settle(
    http.PUT("/missions/{mission_id}", {
      params: { path: { mission_id: base.mission_id }, header: ifUnchanged(base) },
      body: { steps: [] },
      bodySerializer: () => body,
      signal: deadline(),
    }),
  );
}

/** Where a mission goes: right before or after another one of its queue, by the other one's id. */
export type Place = { before: string } | { after: string };

export function moveMission(http: Http, id: string, place: Place): Promise<Mission> {
  const params = { path: { mission_id: id } };
  return settle(http.POST("/missions/{mission_id}/move", { params, body: place, signal: deadline() }));
}

export function changeMission(http: Http, id: string, verb: Verb): Promise<Mission> {
  const options = { params: { path: { mission_id: id } }, signal: deadline() };
  switch (verb) {
    case "pause":
      return settle(http.POST("/missions/{mission_id}/pause", options));
    case "continue":
      return settle(http.POST("/missions/{mission_id}/continue", options));
    case "skip":
      return settle(http.POST("/missions/{mission_id}/skip", options));
    case "cancel":
      return settle(http.POST("/missions/{mission_id}/cancel", options));
  }
}
