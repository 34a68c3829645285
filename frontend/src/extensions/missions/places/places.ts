import { type PoseDraft, poseDraft, poseErrors, poseOf } from "../../../scene/poseDraft";
import { named, type Stored, sorted, useStored } from "../stored";
import type { Place, PlaceBody } from "./requests";
import { deletePlace, listPlaces, putPlace } from "./requests";

export type NamedPlace = Place & { name: string };

export const PLACES: Stored<NamedPlace, PlaceBody> = {
  key: ["places"],
  list: async (http) => sorted((await listPlaces(http)).map(named)),
  put: async (http, id, body, base) => named(await putPlace(http, id, body, base)),
  remove: deletePlace,
};

/** The places that missions drive to, by name. */
export function usePlaces() {
  return useStored(PLACES);
}

/** A place as it is typed. */
export interface PlaceDraft extends PoseDraft {
  name: string;
}

export function draftOf(place: NamedPlace | null): PlaceDraft {
  return { name: place?.name ?? "", ...poseDraft(place && { ...place, theta: place.yaw }) };
}

/** What is wrong with each field. */
export function errorsOf(draft: PlaceDraft): Partial<Record<keyof PlaceDraft, string>> {
  return { ...(draft.name.trim() === "" && { name: "Type a name." }), ...poseErrors(draft) };
}

export function bodyOf(draft: PlaceDraft, by: string | null): PlaceBody {
  const { theta, ...pose } = poseOf(draft);
  return { name: draft.name.trim(), ...pose, yaw: theta, by };
}
