import { type components, deadline, type Http, type paths, settle } from "@dock-gateway/client";
import { type Base, ifUnchanged } from "../../api/version";

type Schemas = components["schemas"];

/** A dock that several robots share. */
export type SharedDock = Schemas["SharedDock"];
export type DockPose = Schemas["DockPose"];
export type DockState = Schemas["DockState"];
/** What a client says of a dock. */
export type DockBody = paths["/shared-docks/{dock_id}"]["put"]["requestBody"]["content"]["application/json"];
/** What a person has seen at a dock. */
export type DockReport =
  paths["/shared-docks/{dock_id}/report"]["post"]["requestBody"]["content"]["application/json"];

export async function listDocks(http: Http): Promise<SharedDock[]> {
  return (await settle(http.GET("/shared-docks", { signal: deadline() }))).shared_docks;
}

/** @param base The dock that it replaces, as it was read; null where there must be none. */
export function putDock(http: Http, dock_id: string, body: DockBody, base: Base): Promise<SharedDock> {
  const params = { path: { dock_id }, header: ifUnchanged(base) };
  return settle(http.PUT("/shared-docks/{dock_id}", { params, body, signal: deadline() }));
}

export async function deleteDock(http: Http, dock: SharedDock): Promise<void> {
  const params = { path: { dock_id: dock.dock_id }, header: ifUnchanged(dock) };
  await settle(http.DELETE("/shared-docks/{dock_id}", { params, signal: deadline() }));
}

export function reportDock(http: Http, dock_id: string, body: DockReport): Promise<SharedDock> {
  const params = { path: { dock_id } };
  return settle(http.POST("/shared-docks/{dock_id}/report", { params, body, signal: deadline() }));
}
