import type { Scene } from "../api/types";
import { distance, type Point } from "./geometry";

/** Points closer together than this become one. */
const SPACING_M = 0.015;
/** A robot that moves farther at once was carried: the trail begins anew. */
export const JUMP_M = 0.4;
export const MAX_POINTS = 2000;

/** Where the robot has been, oldest first; bounded. */
export class Trail {
  #points: Point[] = [];

  get points(): readonly Point[] {
    return this.#points;
  }

  /** Adds where the robot is now. */
  push({ x, y }: Point): void {
    const last = this.#points.at(-1);
    if (last !== undefined) {
      const moved = distance(last, { x, y });
      if (moved < SPACING_M) return;
      if (moved > JUMP_M) this.clear();
    }
    this.#points.push({ x, y });
    // In batches: moving the array for every point is not for free.
    if (this.#points.length >= MAX_POINTS + 200) this.#points = this.#points.slice(-MAX_POINTS);
  }

  /** Puts where the robot was before in front. */
  precede(earlier: readonly Point[]): void {
    const later = this.#points;
    this.clear();
    for (const point of [...earlier, ...later]) this.push(point);
  }

  clear(): void {
    this.#points = [];
  }
}

/** The way through scenes, oldest first; it starts again where the frame is another. */
export function trailOf(scenes: readonly Scene[]): Trail {
  const trail = new Trail();
  for (const [index, { frame, robot }] of scenes.entries()) {
    if (index > 0 && scenes[index - 1]?.frame !== frame) trail.clear();
    trail.push(robot);
  }
  return trail;
}
