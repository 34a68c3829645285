/** The moment that plots, rows and events mark together: under the pointer, else the one that is held. */
export class Crosshair {
  #pointed: number | null = null;
  #held: number | null = null;
  readonly #listeners = new Set<() => void>();

  get moment(): number | null {
    return this.#pointed ?? this.#held;
  }

  get held(): number | null {
    return this.#held;
  }

  /** The pointer or the focus is on that moment; on none for null. */
  readonly point = (moment: number | null): void => {
    if (this.#pointed === moment) return;
    this.#pointed = moment;
    this.#tell();
  };

  /** Stays at that moment; at none for null. */
  readonly hold = (moment: number | null): void => {
    if (this.#held === moment) return;
    this.#held = moment;
    this.#tell();
  };

  readonly subscribe = (listener: () => void): (() => void) => {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  };

  #tell(): void {
    for (const listener of this.#listeners) listener();
  }
}

/** The last of ascending numbers that is not beyond a moment; -1 where all of them are. */
export function lastUpTo(moment: number, count: number, at: (index: number) => number): number {
  let [low, high] = [0, count];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (at(middle) <= moment) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}
