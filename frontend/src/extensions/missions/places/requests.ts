import { type components, deadline, type Http, type paths, settle } from "@dock-gateway/client";
import { type Base, ifUnchanged } from "../../../api/version";

/** A pose with an id, that missions drive to. */
export type Place = components["schemas"]["Place"];
export type PlaceBody = paths["/places/{place_id}"]["put"]["requestBody"]["content"]["application/json"];

export async function listPlaces(http: Http): Promise<Place[]> {
  return (await settle(http.GET("/places", { signal: deadline() }))).places;
}

/** @param base The place that it replaces, as it was read. */
export function putPlace(http: Http, id: string, body: PlaceBody, base: Base): Promise<Place> {
  const params = { path: { place_id: id }, header: ifUnchanged(base) };
  return settle(http.PUT("/places/{place_id}", { params, body, signal: deadline() }));
}

export async function deletePlace(http: Http, place: Place): Promise<void> {
  const params = { path: { place_id: place.id }, header: ifUnchanged(place) };
  await settle(http.DELETE("/places/{place_id}", { params, signal: deadline() }));
}
