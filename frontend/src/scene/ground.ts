import type { Point } from "../store/geometry";
import type { SceneColors } from "./colors";
import { gridStep, type Size, toScreen, toWorld, type View } from "./view";

/** What part of the plane is drawn, and how. */
export interface Drawing {
  view: View;
  size: Size;
  colors: SceneColors;
}

/** What the ground is made of. */
interface Surface extends Drawing {
  /** Where the robot has been, oldest first: an array that grows, or another one. */
  trail: readonly Point[];
  robot: Point;
}

/**
 * The grid and the trail, below everything else: drawn once, and only what the trail gains is added. A robot that has
 * driven for minutes has a trail that costs more than all the rest of the picture.
 */
export class Ground {
  readonly #canvas = document.createElement("canvas");
  #drawn: Surface | null = null;
  /** The number of points of the trail that are drawn. */
  #points = 0;

  /** Puts the ground on a canvas, instead of what was there, and the trail's end up to the robot. */
  draw(ctx: CanvasRenderingContext2D, surface: Surface): void {
    const ground = this.#context(ctx, surface);
    if (ground === null) return;
    if (this.#points < surface.trail.length) {
      drawLine(ground, surface, surface.trail.slice(Math.max(0, this.#points - 1)));
      this.#points = surface.trail.length;
    }
    ctx.save();
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.globalCompositeOperation = "copy";
    ctx.drawImage(this.#canvas, 0, 0);
    ctx.restore();
    drawLine(ctx, surface, [...surface.trail.slice(-1), surface.robot]);
  }

  /** The ground as far as it can stay, or a new one with nothing but the grid. */
  #context(ctx: CanvasRenderingContext2D, surface: Surface): CanvasRenderingContext2D | null {
    const { width, height } = ctx.canvas;
    const ground = this.#canvas.getContext("2d");
    if (ground === null || this.#stays(surface, width, height)) return ground;
    this.#drawn = surface;
    this.#points = 0;
    this.#canvas.width = width;
    this.#canvas.height = height;
    ground.setTransform(width / surface.size.width, 0, 0, height / surface.size.height, 0, 0);
    drawGrid(ground, surface);
    return ground;
  }

  #stays({ view, size, colors, trail }: Surface, width: number, height: number): boolean {
    const drawn = this.#drawn;
    return (
      drawn !== null &&
      this.#canvas.width === width &&
      this.#canvas.height === height &&
      drawn.view === view &&
      drawn.size === size &&
      drawn.colors === colors &&
      drawn.trail === trail
    );
  }
}

/** So far from a corner no metres are written (CSS pixels): there are those of the other axis, and the scale. */
const CORNER_PX = 28;

/** Lines at round distances, with their metres: those of x along the top, those of y along the left. */
export function drawGrid(ctx: CanvasRenderingContext2D, { view, size, colors }: Drawing): void {
  const step = gridStep(view.scale, 44);
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const metres = (value: number) => value.toFixed(decimals).replace("-", "\u2212");
  ctx.font = "11px system-ui, sans-serif";
  ctx.fillStyle = colors.metres;
  const { x: left, y: top } = toWorld(view, size, { x: 0, y: 0 });
  const { x: right, y: bottom } = toWorld(view, size, { x: size.width, y: size.height });
  ctx.lineWidth = 1;
  const line = (axis: boolean, x1: number, y1: number, x2: number, y2: number) => {
    ctx.strokeStyle = axis ? colors.axis : colors.grid;
    ctx.beginPath();
    ctx.moveTo(x1, y1);
    ctx.lineTo(x2, y2);
    ctx.stroke();
  };
  ctx.textAlign = "center";
  ctx.textBaseline = "top";
  for (let column = Math.ceil(left / step); column * step <= right; column += 1) {
    const x = Math.round(toScreen(view, size, { x: column * step, y: 0 }).x) + 0.5;
    line(column === 0, x, 0, x, size.height);
    if (x > CORNER_PX && x < size.width - CORNER_PX) ctx.fillText(metres(column * step), x, 4);
  }
  ctx.textAlign = "left";
  ctx.fillText("m", 4, 4);
  ctx.textBaseline = "middle";
  for (let row = Math.ceil(bottom / step); row * step <= top; row += 1) {
    const y = Math.round(toScreen(view, size, { x: 0, y: row * step }).y) + 0.5;
    line(row === 0, 0, y, size.width, y);
    if (y > CORNER_PX && y < size.height - 2 * CORNER_PX) ctx.fillText(metres(row * step), 4, y);
  }
}

function drawLine(
  ctx: CanvasRenderingContext2D,
  { view, size, colors }: Surface,
  points: readonly Point[],
): void {
  ctx.beginPath();
  for (const point of points) {
    const { x, y } = toScreen(view, size, point);
    ctx.lineTo(x, y);
  }
  ctx.strokeStyle = colors.trail;
  ctx.lineWidth = 2;
  ctx.lineJoin = "round";
  ctx.lineCap = "round";
  ctx.stroke();
  ctx.lineCap = "butt";
}
