import type { Pose } from "@dock-gateway/client";
import { toScreen, toWorld } from "../../scene/view";
import {
  compose,
  distance,
  normalizeAngle,
  type Point,
  place,
  type Size,
  type View,
} from "../../store/geometry";
import type { GroundPicture } from "../../store/layers";
import type { MapJob } from "./mapWorker";
import type { Grid } from "./requests";

/** Each copy of a map has half the columns and rows of the one before, down to this many. */
const LEAST_SIDE = 256;
/** A picture of more pixels is never held: a map with more cells begins with a smaller copy. */
const MOST_PIXELS = 36_000_000;
/** A map that has moved by less stays where it is drawn: `tf` is never quite at rest (m, rad). */
const STILL_M = 0.003;
const STILL_RAD = 0.0005;
const AGAIN_MS = 5000;

/** A map as it is drawn. */
interface DrawnMap extends GroundPicture {
  grid: Grid;
  /** Its lower left corner, in the frame that is drawn. */
  corner: Pose;
}

/** The picture of a map: fetched once for each revision, and kept in several sizes, so that no frame draws more than it shows. */
export class MapImage {
  #levels: ImageBitmap[] = [];
  #revision: string | null = null;
  /** The grid of the picture that is shown. */
  #shown: Grid | null = null;
  #drawn: DrawnMap | null = null;
  #timer: ReturnType<typeof setTimeout> | undefined;
  #closed = false;

  constructor(
    private readonly load: () => Promise<Blob>,
    /** Called where there is another picture. */
    private readonly onChange: () => void,
  ) {}

  close(): void {
    this.#closed = true;
    clearTimeout(this.#timer);
    this.#release();
  }

  /** Fetches the picture of a map, unless it is that of the last call. */
  show(grid: Grid | null): void {
    if (this.#closed || grid === null || grid.revision === this.#revision) return;
    this.#revision = grid.revision;
    clearTimeout(this.#timer);
    void this.#fetch(grid);
  }

  async #fetch(grid: Grid): Promise<void> {
    let levels: ImageBitmap[] = [];
    try {
      levels = await levelsOf(await this.load(), grid);
    } catch {
      // What is wrong with the connection is said at the top of the page.
      if (this.#closed || this.#revision !== grid.revision) return;
      this.#revision = null;
      this.#timer = setTimeout(() => this.show(grid), AGAIN_MS);
      return;
    }
    if (this.#closed || this.#revision !== grid.revision) {
      for (const level of levels) level.close();
      return;
    }
    this.#release();
    this.#levels = levels;
    this.#shown = grid;
    this.onChange();
  }

  #release(): void {
    for (const level of this.#levels) level.close();
    this.#levels = [];
    this.#shown = null;
    this.#drawn = null;
  }

  /** The map in its place; null without a picture, or without a place. @param frame The map's frame, in the one that is drawn. */
  placeAt(frame: Pose | null): GroundPicture | null {
    const grid = this.#shown;
    if (grid === null || frame === null) return null;
    const corner = compose(frame, grid.origin);
    const before = this.#drawn;
    if (before === null || before.grid !== grid || !isStill(before.corner, corner))
      this.#drawn = { grid, corner, draw: (ctx, view, size) => this.#draw(ctx, view, size, grid, corner) };
    return this.#drawn;
  }

  /** Draws what is seen of it. */
  #draw(ctx: CanvasRenderingContext2D, view: View, size: Size, grid: Grid, corner: Pose): void {
    const first = this.#levels[0];
    if (first === undefined) return;
    const { width, height, resolution } = grid;
    const pixel = view.scale * resolution;
    const level =
      this.#levels.find((each) => (pixel * width) / each.width > 0.75) ?? this.#levels.at(-1) ?? first;
    const [across, up] = [width / level.width, height / level.height];
    // Only what is on the canvas: a source of 16 million pixels costs no more than the part that is shown.
    const { left, right, bottom, top } = visible(view, size, corner, grid);
    if (left >= right || bottom >= top) return;
    const at = toScreen(view, size, corner);
    ctx.save();
    ctx.translate(at.x, at.y);
    ctx.rotate(-corner.theta);
    ctx.imageSmoothingEnabled = pixel * across < 1.5;
    ctx.drawImage(
      level,
      left / across,
      (height - top) / up,
      (right - left) / across,
      (top - bottom) / up,
      left * pixel,
      -top * pixel,
      (right - left) * pixel,
      (top - bottom) * pixel,
    );
    ctx.restore();
  }
}

/** The columns and rows of a map that are on a canvas. */
function visible(view: View, size: Size, corner: Pose, { width, height, resolution }: Grid) {
  const cells = [
    { x: 0, y: 0 },
    { x: size.width, y: 0 },
    { x: 0, y: size.height },
    { x: size.width, y: size.height },
  ].map((pixel) => {
    const point = toWorld(view, size, pixel);
    const [dx, dy] = [point.x - corner.x, point.y - corner.y];
    const [cos, sin] = [Math.cos(corner.theta), Math.sin(corner.theta)];
    return { x: (cos * dx + sin * dy) / resolution, y: (cos * dy - sin * dx) / resolution };
  });
  const [xs, ys] = [cells.map(({ x }) => x), cells.map(({ y }) => y)];
  return {
    left: Math.max(0, Math.floor(Math.min(...xs))),
    right: Math.min(width, Math.ceil(Math.max(...xs))),
    bottom: Math.max(0, Math.floor(Math.min(...ys))),
    top: Math.min(height, Math.ceil(Math.max(...ys))),
  };
}

/** The corners of a map, in the frame that is drawn; none without a map, or where the two are not related. */
export function cornersOf(grid: Grid | null, frame: Pose | null): Point[] {
  if (grid === null || frame === null) return [];
  const corner = compose(frame, grid.origin);
  const [x, y] = [grid.width * grid.resolution, grid.height * grid.resolution];
  return [
    { x: 0, y: 0 },
    { x, y: 0 },
    { x: 0, y },
    { x, y },
  ].map((point) => place(corner, point));
}

function isStill(before: Pose, after: Pose): boolean {
  const turned = Math.abs(normalizeAngle(after.theta - before.theta));
  return distance(before, after) < STILL_M && turned < STILL_RAD;
}

/** A picture in several sizes, the largest first: made by a worker, as a browser makes smaller ones in the page's own time. */
async function levelsOf(blob: Blob, { width, height }: Grid): Promise<ImageBitmap[]> {
  const sizes: [number, number][] = [];
  for (
    let [columns, rows] = [width, height];
    ;
    [columns, rows] = [Math.ceil(columns / 2), Math.ceil(rows / 2)]
  ) {
    if (columns * rows <= MOST_PIXELS) sizes.push([columns, rows]);
    if (Math.max(columns, rows) <= LEAST_SIDE) break;
  }
  const worker = new Worker(new URL("./mapWorker.ts", import.meta.url), { type: "module" });
  try {
    return await new Promise((resolve, reject) => {
      worker.onmessage = ({ data }: MessageEvent<ImageBitmap[] | null>) =>
        data === null ? reject(new Error("The map is no image.")) : resolve(data);
      worker.onerror = reject;
      worker.postMessage({ blob, sizes } satisfies MapJob);
    });
  } finally {
    worker.terminate();
  }
}
