import type { Point, Size } from "../store/geometry";

/** Where the labels of a picture are, so that none lies on another one. */
export class Labels {
  readonly #taken: { left: number; top: number; right: number; bottom: number }[] = [];

  /** Takes the place of a label if no other one is there. @param top The middle of its upper edge. */
  take({ x, y: top }: Point, { width, height }: Size): boolean {
    const [left, right, bottom] = [x - width / 2, x + width / 2, top + height];
    const free = this.#taken.every(
      (other) => right <= other.left || left >= other.right || bottom <= other.top || top >= other.bottom,
    );
    if (free) this.#taken.push({ left, top, right, bottom });
    return free;
  }
}
