import type { Pose } from "@dock-gateway/client";
import { distance, type Point } from "../store/geometry";
import type { Mark } from "../store/layers";
import type { Drawing } from "./ground";
import { toScreen } from "./view";

const DOT_PX = 2.5;
/** What is so much farther than the nearest dot still belongs to the obstacle (m). */
const OBSTACLE_M = 0.2;

/** A line with a ring at its end, such as a planned path. */
export function drawLine(
  ctx: CanvasRenderingContext2D,
  { view, size }: Drawing,
  { points, color }: Mark,
): void {
  if (points.length < 2) return;
  ctx.save();
  ctx.beginPath();
  for (const point of points) {
    const { x, y } = toScreen(view, size, point);
    ctx.lineTo(x, y);
  }
  ctx.strokeStyle = color;
  ctx.lineWidth = 2.5;
  ctx.setLineDash([7, 5]);
  ctx.lineJoin = "round";
  ctx.stroke();
  const end = toScreen(view, size, points.at(-1) as Point);
  ctx.setLineDash([]);
  ctx.beginPath();
  ctx.arc(end.x, end.y, 5, 0, 2 * Math.PI);
  ctx.stroke();
  ctx.restore();
}

/** Dots, such as what a laser sees. @param blocked The robot waits for the nearest ones: they stand out. */
export function drawDots(
  ctx: CanvasRenderingContext2D,
  { view, size, colors }: Drawing,
  robot: Pose,
  { points: all, color }: Mark,
  blocked: boolean,
): void {
  const nearest = blocked ? Math.min(...all.map((point) => distance(point, robot))) + OBSTACLE_M : -1;
  const near = all.filter((point) => distance(point, robot) <= nearest);
  dots(all, DOT_PX, color);
  dots(near, DOT_PX * 2, colors.obstacle);

  function dots(points: readonly Point[], width: number, color: string): void {
    ctx.fillStyle = color;
    ctx.beginPath();
    for (const point of points) {
      const { x, y } = toScreen(view, size, point);
      ctx.rect(x - width / 2, y - width / 2, width, width);
    }
    ctx.fill();
  }
}
