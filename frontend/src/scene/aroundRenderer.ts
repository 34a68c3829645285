import type { Pose } from "@dock-gateway/client";
import { distance, type Point } from "../store/geometry";
import type { Seen } from "./around";
import type { Drawing } from "./ground";
import { toScreen } from "./view";

const DOT_PX = 2.5;
/** What is so much farther than the nearest point that a laser sees still belongs to the obstacle (m). */
const OBSTACLE_M = 0.2;

/** The planned path, below the robot. */
export function drawPath(
  ctx: CanvasRenderingContext2D,
  { view, size, colors }: Drawing,
  { path }: Seen,
): void {
  if (path.length < 2) return;
  ctx.save();
  ctx.beginPath();
  for (const point of path) {
    const { x, y } = toScreen(view, size, point);
    ctx.lineTo(x, y);
  }
  ctx.strokeStyle = colors.path;
  ctx.lineWidth = 2.5;
  ctx.setLineDash([7, 5]);
  ctx.lineJoin = "round";
  ctx.stroke();
  const end = toScreen(view, size, path.at(-1) as Point);
  ctx.setLineDash([]);
  ctx.beginPath();
  ctx.arc(end.x, end.y, 5, 0, 2 * Math.PI);
  ctx.stroke();
  ctx.restore();
}

/** What the laser sees; what the robot waits for stands out. */
export function drawScan(
  ctx: CanvasRenderingContext2D,
  { view, size, colors }: Drawing,
  robot: Pose,
  { scan, blocked }: Seen,
): void {
  const nearest = blocked ? Math.min(...scan.map((point) => distance(point, robot))) + OBSTACLE_M : -1;
  const near = scan.filter((point) => distance(point, robot) <= nearest);
  dots(scan, DOT_PX, colors.scan);
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
