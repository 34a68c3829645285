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

/** A place as it is typed: in metres and degrees. */
export interface PlaceDraft {
  name: string;
  x: number | string;
  y: number | string;
  heading: number | string;
  frame: string;
}

export function draftOf(place: NamedPlace | null): PlaceDraft {
  const { name = "", x = "", y = "", yaw = 0, frame = "map" } = place ?? {};
  return { name, x, y, heading: degrees(yaw), frame };
}

export function degrees(yaw: number): number {
  return Math.round((yaw * 180_000) / Math.PI) / 1000;
}

/** What is wrong with each field. */
export function errorsOf({ name, x, y, heading, frame }: PlaceDraft) {
  const errors: Partial<Record<keyof PlaceDraft, string>> = {};
  if (name.trim() === "") errors.name = "Type a name.";
  if (typeof x !== "number" || Math.abs(x) > 1e6) errors.x = "A number of metres";
  if (typeof y !== "number" || Math.abs(y) > 1e6) errors.y = "A number of metres";
  if (typeof heading !== "number" || Math.abs(heading) > 360) errors.heading = "From -360° to 360°";
  if (frame.trim() === "") errors.frame = "The name of a frame";
  return errors;
}

export function bodyOf({ name, x, y, heading, frame }: PlaceDraft, by: string | null): PlaceBody {
  const yaw = (Number(heading) * Math.PI) / 180;
  return { name: name.trim(), x: Number(x), y: Number(y), yaw, frame: frame.trim(), by };
}

/** `x 1.5 m, y -2 m, 90°` */
export function poseWords({ x, y, yaw, frame }: Pick<Place, "x" | "y" | "yaw" | "frame">): string {
  const turned = yaw === 0 ? "" : `, ${Math.round(degrees(yaw))}°`;
  return `x ${shortened(x)} m, y ${shortened(y)} m${turned}${frame === "map" ? "" : ` in ${frame}`}`;
}

function shortened(metres: number): number {
  return Math.round(metres * 100) / 100;
}
