import type { Point, Size, View } from "../store/geometry";
import { keep, readKept } from "../ui/kept";
import { shortest } from "../ui/numbers";

/** A map of 200 m fits into a picture. */
const MIN_SCALE = 2;
export const MAX_SCALE = 1500;

/** Space around what is to be seen, in metres: a robot's size and a little more. */
const MARGIN_M = 0.45;
/** A view fitted by itself shows no less than this, in metres, so that a robot on its dock still has a place. */
const MIN_SPAN_M = 1.6;
/** The page's own view closes in when what is to be seen needs less than this share of it. */
const LOOSE = 0.4;

/** A point of the plane on the canvas, in CSS pixels. x is to the right, y up. */
export function toScreen(view: View, size: Size, point: Point): Point {
  return {
    x: size.width / 2 + (point.x - view.x) * view.scale,
    y: size.height / 2 - (point.y - view.y) * view.scale,
  };
}

/** The point of the plane at a place on the canvas. */
export function toWorld(view: View, size: Size, place: Point): Point {
  return {
    x: view.x + (place.x - size.width / 2) / view.scale,
    y: view.y - (place.y - size.height / 2) / view.scale,
  };
}

/** Closer by `factor`; the point of the plane at `place` stays there. */
export function zoom(view: View, size: Size, place: Point, factor: number): View {
  const scale = Math.min(MAX_SCALE, Math.max(MIN_SCALE, view.scale * factor));
  const fixed = toWorld(view, size, place);
  return {
    x: fixed.x - (place.x - size.width / 2) / scale,
    y: fixed.y + (place.y - size.height / 2) / scale,
    scale,
  };
}

/** Moves the view with a pointer, by a distance in CSS pixels. */
export function pan(view: View, dx: number, dy: number): View {
  return { ...view, x: view.x - dx / view.scale, y: view.y + dy / view.scale };
}

interface Bounds {
  left: number;
  right: number;
  bottom: number;
  top: number;
}

function boundsOf(points: readonly Point[]): Bounds {
  const xs = points.map((point) => point.x);
  const ys = points.map((point) => point.y);
  return { left: Math.min(...xs), right: Math.max(...xs), bottom: Math.min(...ys), top: Math.max(...ys) };
}

/** The view that shows all the points with some space around them. */
export function fitTo(points: readonly Point[], size: Size): View {
  if (points.length === 0) return { x: 0, y: 0, scale: Math.max(MIN_SCALE, size.height / MIN_SPAN_M) };
  const { left, right, bottom, top } = boundsOf(points);
  const width = Math.max(right - left + 2 * MARGIN_M, MIN_SPAN_M);
  const height = Math.max(top - bottom + 2 * MARGIN_M, MIN_SPAN_M);
  const scale = Math.min(size.width / width, size.height / height);
  return {
    x: (left + right) / 2,
    y: (bottom + top) / 2,
    scale: Math.min(MAX_SCALE, Math.max(MIN_SCALE, scale)),
  };
}

/**
 * The view to go on with where the page chooses it: the present one for as long as it shows all the points and is not
 * much too wide, so that the ground does not slide under a robot that moves.
 */
export function follow(view: View | null, points: readonly Point[], size: Size): View {
  const fitted = fitTo(points, size);
  if (view === null || points.length === 0) return fitted;
  const { left, right, bottom, top } = boundsOf(points);
  const half = { x: size.width / 2 / view.scale, y: size.height / 2 / view.scale };
  const room = MARGIN_M / 2;
  const inside =
    left - room >= view.x - half.x &&
    right + room <= view.x + half.x &&
    bottom - room >= view.y - half.y &&
    top + room <= view.y + half.y;
  return inside && view.scale >= fitted.scale * LOOSE ? view : fitted;
}

/** The step of a grid whose lines are at least `apart` CSS pixels from each other: 1, 2 or 5 times a power of ten. */
export function gridStep(scale: number, apart: number): number {
  const least = apart / scale;
  const power = 10 ** Math.floor(Math.log10(least));
  const factor = [1, 2, 5, 10].find((each) => each * power >= least * (1 - 1e-9)) ?? 10;
  return factor * power;
}

/** A length in the unit that suits it: `50 cm`, `2 m`. */
export function formatLength(metres: number): string {
  return metres < 1 ? `${Math.round(metres * 100)} cm` : `${shortest(metres, 3)} m`;
}

/** A canvas with the resolution of the screen, to be drawn on in CSS pixels; null while it has no size. */
export function canvasContext(
  canvas: HTMLCanvasElement,
  { width, height }: Size,
): CanvasRenderingContext2D | null {
  if (width === 0 || height === 0) return null;
  const ratio = window.devicePixelRatio || 1;
  const [columns, rows] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== columns || canvas.height !== rows) {
    canvas.width = columns;
    canvas.height = rows;
  }
  const context = canvas.getContext("2d");
  context?.setTransform(columns / width, 0, 0, rows / height, 0, 0);
  return context;
}

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
