import { distance, type Point, type Size, type View } from "../store/geometry";
import { fitTo, follow, pan, toWorld, zoom } from "./view";

/** The view comes this much closer to where it is going in a time of this length (ms). */
const EASE_MS = 90;
/** Who has moved by less than this stands still, to the eye: odometry is never quite at rest. In CSS pixels. */
export const STILL_PX = 0.5;

/**
 * Chooses what part of the plane is seen, and glides there: all that there is to see, until somebody zooms or pans, or
 * what is around a robot that is followed.
 */
export class Camera {
  /** Called where a robot is followed at another scale (CSS pixels a metre), or is not followed any more (null). */
  onFollow: (scale: number | null) => void = () => {};
  #size: Size = { width: 0, height: 0 };
  #view: View | null = null;
  #target: View | null = null;
  #chosenByHand = false;
  #followedScale: number | null = null;
  /** Where the followed robot was; null before it is in the middle of the target. */
  #followedAt: Point | null = null;

  /** @param inset So far from the edges all that is to be seen is kept, where it chooses by itself (CSS pixels). */
  constructor(private readonly inset = 0) {}

  get size(): Size {
    return this.#size;
  }

  get view(): View {
    return this.#view ?? fitTo([], this.#size);
  }

  /** Whether it is still on its way. */
  get glides(): boolean {
    return this.#view !== this.#target;
  }

  /** Whether the size is another one. */
  resize(size: Size): boolean {
    if (size.width === this.#size.width && size.height === this.#size.height) return false;
    this.#size = size;
    if (!this.#chosenByHand) this.#view = null;
    return true;
  }

  /** Closer by `factor` around a place on the canvas, its middle by default; a robot that is followed stays in the middle. */
  zoomBy(factor: number, place?: Point): void {
    const middle = { x: this.#size.width / 2, y: this.#size.height / 2 };
    const scale = this.#followedScale;
    if (scale === null) this.#choose(zoom(this.#target ?? this.view, this.#size, place ?? middle, factor));
    else this.#setFollowed(zoom({ ...this.view, scale }, this.#size, middle, factor).scale);
  }

  panBy(dx: number, dy: number): void {
    const target = this.#target ?? this.view;
    this.#view = pan(this.view, dx, dy);
    this.#choose(pan(target, dx, dy));
  }

  /** Back to the view that shows all the points. */
  showAll(points: readonly Point[]): void {
    this.#choose(fitTo(points, this.#inside));
    this.#chosenByHand = false;
  }

  /** Shows all the points, and stays there. */
  frame(points: readonly Point[]): void {
    this.#choose(fitTo(points, this.#inside));
  }

  /** Keeps the robot in the middle at this scale, until somebody pans or all is to be shown; no longer for null. */
  follow(scale: number | null): void {
    this.#chosenByHand = false;
    this.#followedAt = null;
    this.#setFollowed(scale);
  }

  toWorld(place: Point): Point {
    return toWorld(this.view, this.#size, place);
  }

  /** Chooses again where it does so by itself. @param points What is to be seen. @param robot Which is followed. */
  aim(points: readonly Point[], robot: Point | null): void {
    if (this.#followedScale !== null && robot !== null) this.#aimAt(robot, this.#followedScale);
    else if (!this.#chosenByHand) this.#target = follow(this.#target, points, this.#inside);
  }

  /** @param elapsed Since the last time (ms). @param calm At once, where motion is not wanted. */
  glide(elapsed: number, calm: boolean): void {
    const [view, target] = [this.#view, this.#target];
    if (target === null) return;
    if (view === null || calm) {
      this.#view = target;
      return;
    }
    const share = 1 - Math.exp(-Math.min(elapsed, 100) / EASE_MS);
    const next = {
      x: view.x + (target.x - view.x) * share,
      y: view.y + (target.y - view.y) * share,
      scale: view.scale * (target.scale / view.scale) ** share,
    };
    const left = distance(target, next) * next.scale;
    const settled = left < 0.3 && Math.abs(target.scale / next.scale - 1) < 0.002;
    this.#view = settled ? target : next;
  }

  get #inside(): Size {
    const { width, height } = this.#size;
    return { width: Math.max(1, width - 2 * this.inset), height: Math.max(1, height - 2 * this.inset) };
  }

  /** What is seen goes along with the robot; only what somebody has chosen, such as another scale, is glided to. */
  #aimAt({ x, y }: Point, scale: number): void {
    const [view, before, last] = [this.#view, this.#target, this.#followedAt];
    const rescaled = before?.scale !== scale;
    if (last !== null && !rescaled && distance(last, { x, y }) * scale < STILL_PX) return;
    this.#followedAt = { x, y };
    this.#target = { x, y, scale };
    if (last === null || view === null) return;
    const along = { ...view, x: view.x + x - last.x, y: view.y + y - last.y };
    this.#view = view === before && !rescaled ? this.#target : along;
  }

  #choose(view: View): void {
    this.#setFollowed(null);
    this.#chosenByHand = true;
    this.#target = view;
  }

  #setFollowed(scale: number | null): void {
    if (scale === this.#followedScale) return;
    this.#followedScale = scale;
    this.onFollow(scale);
  }
}
