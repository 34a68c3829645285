import { MAX_SCALE, MIN_SCALE } from "./view";

const KEY = "dock-gateway-map-follow";

/** The scale (CSS pixels a metre) at which maps keep their robot in the middle; null where they show everything. */
export function keptScale(): number | null {
  try {
    const scale = Number(localStorage.getItem(KEY));
    return scale >= MIN_SCALE && scale <= MAX_SCALE ? scale : null;
  } catch {
    return null;
  }
}

/** For every map, in this browser. */
export function keepScale(scale: number | null): void {
  try {
    if (scale === null) localStorage.removeItem(KEY);
    else localStorage.setItem(KEY, String(scale));
  } catch {
    // Storage is blocked: it holds until the page is closed.
  }
}
