import type { Point } from "../store/geometry";
import type { Camera } from "./camera";
import type { Size, View } from "./view";

/** A picture of the ground on a canvas, as its camera sees it. */
export abstract class Picture {
  /** Nothing is drawn while the canvas is out of sight. */
  #inSight = true;

  constructor(protected readonly camera: Camera) {}

  /** Draws in the next frame. */
  abstract readonly invalidate: () => void;

  /** What is to be seen where nobody has chosen a part of it. */
  protected abstract points(): Point[];

  abstract destroy(): void;

  get size(): Size {
    return this.camera.size;
  }

  get view(): View {
    return this.camera.view;
  }

  get inSight(): boolean {
    return this.#inSight;
  }

  set inSight(inSight: boolean) {
    this.#inSight = inSight;
    if (inSight) this.invalidate();
  }

  resize(size: Size): void {
    if (this.camera.resize(size)) this.invalidate();
  }

  /** Closer by `factor` around a place on the canvas, its middle by default. */
  zoomBy(factor: number, place?: Point): void {
    this.camera.zoomBy(factor, place);
    this.invalidate();
  }

  panBy(dx: number, dy: number): void {
    this.camera.panBy(dx, dy);
    this.invalidate();
  }

  /** Back to the view that shows everything. */
  showAll(): void {
    this.camera.showAll(this.points());
    this.invalidate();
  }

  toWorld(place: Point): Point {
    return this.camera.toWorld(place);
  }
}
