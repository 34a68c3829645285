import type { Footprint } from "../../api/types";

/** The circle around a footprint is a little smaller than the element that shows it (%). */
const RADIUS = 47;

/** A footprint as a CSS shape: of a square element with base_link in its middle, x to the right. */
export function outlineOf({ radius, points }: Footprint): string {
  if (points === null) return `circle(${RADIUS}%)`;
  const place = (metres: number) => `${(50 + (RADIUS * metres) / radius).toFixed(1)}%`;
  return `polygon(${points.map(({ x, y }) => `${place(x)} ${place(-y)}`).join(", ")})`;
}
