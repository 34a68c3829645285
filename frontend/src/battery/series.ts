/** What the plot shows: the last five minutes. */
export const WINDOW_S = 300;

/** Points closer together than this become one, so that 100 messages a second need no more room than ten. */
const MIN_SPACING_S = 0.1;

/** A pause longer than this is a gap in the line, not a line across. */
const GAP_S = 15;

export type Column = (number | null)[];

/**
 * The battery's recent past in the shape that uPlot takes: times (s since 1970), percentage (0 to 100) and voltage.
 * Bounded by the window and the spacing.
 */
export class BatterySeries {
  #times: number[] = [];
  #percentages: Column = [];
  #voltages: Column = [];
  /** Changes with every push, so that a drawing knows whether it is up to date. */
  version = 0;

  get length(): number {
    return this.#times.length;
  }

  get data(): [number[], Column, Column] {
    return [this.#times, this.#percentages, this.#voltages];
  }

  /** Adds a measurement; one that is older than the last is left out. */
  push(timeMs: number, percentage: number | null, voltage: number | null): void {
    const time = timeMs / 1000;
    const last = this.#times.at(-1);
    if (last !== undefined && time < last) return;
    this.version += 1;
    const percent = percentage === null ? null : percentage * 100;
    const beforeLast = this.#times.at(-2);
    if (beforeLast !== undefined && time - beforeLast < MIN_SPACING_S) {
      this.#times[this.length - 1] = time;
      this.#percentages[this.#percentages.length - 1] = percent;
      this.#voltages[this.#voltages.length - 1] = voltage;
      return;
    }
    if (last !== undefined && time - last > GAP_S) this.#append(last + GAP_S / 2, null, null);
    this.#append(time, percent, voltage);
    this.#forget(time - WINDOW_S);
  }

  #append(time: number, percent: number | null, voltage: number | null): void {
    this.#times.push(time);
    this.#percentages.push(percent);
    this.#voltages.push(voltage);
  }

  /** Leaves one point before `oldest`, so that the line enters from the left edge. */
  #forget(oldest: number): void {
    let count = 0;
    while (count + 1 < this.length && (this.#times[count + 1] ?? oldest) < oldest) count += 1;
    // In batches: cutting arrays for every message is the only costly thing here.
    if (count < 64 && count < this.length / 2) return;
    this.#times = this.#times.slice(count);
    this.#percentages = this.#percentages.slice(count);
    this.#voltages = this.#voltages.slice(count);
  }
}
