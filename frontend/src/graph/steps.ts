import type { Place, Places } from "./layout";

export type Direction = "left" | "right" | "up" | "down";

const WAYS: Record<string, Direction> = {
  ArrowLeft: "left",
  ArrowRight: "right",
  ArrowUp: "up",
  ArrowDown: "down",
};

export function directionOf(key: string): Direction | null {
  return WAYS[key] ?? null;
}

/** The id of the nearest in a direction: what is straight ahead is nearer than what is beside. Null where nothing is. */
export function stepFrom(places: Places, from: string, direction: Direction): string | null {
  const start = places.get(from);
  if (start === undefined) return null;
  let nearest: string | null = null;
  let least = Number.POSITIVE_INFINITY;
  for (const [id, place] of places) {
    const distance = distanceTo(start, place, direction);
    if (id !== from && distance < least) [nearest, least] = [id, distance];
  }
  return nearest;
}

function distanceTo(start: Place, end: Place, direction: Direction): number {
  const [x, y] = [end.x - start.x, end.y - start.y];
  const sideways = direction === "left" || direction === "right";
  const ahead = sideways ? x : y;
  const along = direction === "left" || direction === "up" ? -ahead : ahead;
  return along <= 0 ? Number.POSITIVE_INFINITY : along + 2 * Math.abs(sideways ? y : x);
}
