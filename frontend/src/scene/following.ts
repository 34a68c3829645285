import { keep, readKept } from "../ui/kept";
import { MAX_SCALE, MIN_SCALE } from "./view";

const KEY = "dock-gateway-map-follow";

/** The scale (CSS pixels a metre) at which maps keep their robot in the middle; null where they show everything. */
export function keptScale(): number | null {
  const scale = Number(readKept(KEY));
  return scale >= MIN_SCALE && scale <= MAX_SCALE ? scale : null;
}

/** For every map, in this browser. */
export function keepScale(scale: number | null): void {
  keep(KEY, scale === null ? null : String(scale));
}
