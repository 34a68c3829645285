import type { Place } from "./layout";

/** A line through all points that is level at each of them, as an SVG path. */
export function levelPath([first, ...others]: readonly Place[]): string {
  if (first === undefined) return "";
  let from = first;
  const parts = [`M ${from.x} ${from.y}`];
  for (const to of others) {
    const middle = (from.x + to.x) / 2;
    parts.push(`C ${middle} ${from.y} ${middle} ${to.y} ${to.x} ${to.y}`);
    from = to;
  }
  return parts.join(" ");
}
