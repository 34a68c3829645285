import type { Point, Size, View } from "../store/geometry";
import type { GroundPicture } from "../store/layers";
import { fixed } from "../ui/numbers";
import type { SceneColors } from "../ui/tokens";
import { gridStep, toScreen, toWorld } from "./view";

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
  /** The pictures of the layers, the lowest first. */
  pictures: readonly GroundPicture[];
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

  /** Returns the drawn ground if it is still valid, else a new one with the grid alone. */
  #context(ctx: CanvasRenderingContext2D, surface: Surface): CanvasRenderingContext2D | null {
    const { width, height } = ctx.canvas;
    const ground = this.#canvas.getContext("2d");
    if (ground === null || this.#stays(surface, width, height)) return ground;
    this.#drawn = surface;
    this.#points = 0;
    this.#canvas.width = width;
    this.#canvas.height = height;
    ground.setTransform(width / surface.size.width, 0, 0, height / surface.size.height, 0, 0);
    drawGrid(ground, surface, surface.pictures);
    return ground;
  }

  #stays({ view, size, colors, trail, pictures }: Surface, width: number, height: number): boolean {
    const drawn = this.#drawn;
    return (
      drawn !== null &&
      this.#canvas.width === width &&
      this.#canvas.height === height &&
      drawn.view === view &&
      drawn.size === size &&
      drawn.colors === colors &&
      drawn.trail === trail &&
      isSameGround(drawn.pictures, pictures)
    );
  }
}

/** Whether two grounds look the same. */
export function isSameGround(one: readonly GroundPicture[], other: readonly GroundPicture[]): boolean {
  return one.length === other.length && one.every((picture, index) => picture === other[index]);
}

/** So far from a corner no metres are written (CSS pixels): there are those of the other axis, and the scale. */
const CORNER_PX = 28;

/** Lines at round distances, pictures above them, and their metres: those of x along the top, those of y along the left. */
export function drawGrid(
  ctx: CanvasRenderingContext2D,
  drawing: Drawing,
  pictures: readonly GroundPicture[] = [],
): void {
  const { view, size, colors } = drawing;
  const step = gridStep(view.scale, 44);
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const metres = (value: number) => fixed(value, decimals);
  const { x: left, y: top } = toWorld(view, size, { x: 0, y: 0 });
  const { x: right, y: bottom } = toWorld(view, size, { x: size.width, y: size.height });
  const columns = steps(left, right, step).map((column) => ({
    column,
    x: Math.round(toScreen(view, size, { x: column * step, y: 0 }).x) + 0.5,
  }));
  const rows = steps(bottom, top, step).map((row) => ({
    row,
    y: Math.round(toScreen(view, size, { x: 0, y: row * step }).y) + 0.5,
  }));
  ctx.lineWidth = 1;
  const line = (axis: boolean, x1: number, y1: number, x2: number, y2: number) => {
    ctx.strokeStyle = axis ? colors.axis : colors.grid;
    ctx.beginPath();
    ctx.moveTo(x1, y1);
    ctx.lineTo(x2, y2);
    ctx.stroke();
  };
  for (const { column, x } of columns) line(column === 0, x, 0, x, size.height);
  for (const { row, y } of rows) line(row === 0, 0, y, size.width, y);
  for (const picture of pictures) picture.draw(ctx, view, size);
  ctx.font = "11px system-ui, sans-serif";
  ctx.textAlign = "center";
  ctx.textBaseline = "top";
  for (const { column, x } of columns)
    if (x > CORNER_PX && x < size.width - CORNER_PX)
      write(ctx, drawing, metres(column * step), x, 4, colors.metres);
  ctx.textAlign = "left";
  write(ctx, drawing, "m", 4, 4, colors.metres);
  ctx.textBaseline = "middle";
  for (const { row, y } of rows)
    if (y > CORNER_PX && y < size.height - 2 * CORNER_PX)
      write(ctx, drawing, metres(row * step), 4, y, colors.metres);
}

/** The multiples of a step from one value to another, as numbers of steps. */
function steps(from: number, to: number, step: number): number[] {
  const first = Math.ceil(from / step);
  return Array.from({ length: Math.max(0, Math.floor(to / step) - first + 1) }, (_, index) => first + index);
}

/** Writes a text that can be read on any ground. */
export function write(
  ctx: CanvasRenderingContext2D,
  { colors }: Pick<Drawing, "colors">,
  text: string,
  x: number,
  y: number,
  color: string,
): void {
  ctx.strokeStyle = colors.halo;
  ctx.lineWidth = 3;
  ctx.lineJoin = "round";
  ctx.strokeText(text, x, y);
  ctx.fillStyle = color;
  ctx.fillText(text, x, y);
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
