import type { Battery, BatteryState } from "@dock-gateway/client";

/** What is kept of what was heard live: the last five minutes. */
export const WINDOW_S = 300;

/**
 * Points closer together than this become one, with the last value and the span of all: two of them are a pixel of the
 * plot, whatever the rate of messages.
 */
const MIN_SPACING_S = 0.25;

/** The battery's recent past as it was heard. Bounded by the window and the spacing. */
export class BatterySeries {
  #points = noPoints();
  /** Changes with every push, so that a drawing knows whether it is up to date. */
  version = 0;

  get length(): number {
    return this.#points.times.length;
  }

  get points(): Points {
    return this.#points;
  }

  /** Adds a measurement; one that is older than the last is left out. */
  push(timeMs: number, state: BatteryState): void {
    const time = timeMs / 1000;
    const { times, bands } = this.#points;
    const last = times.at(-1);
    if (last !== undefined && time < last) return;
    this.version += 1;
    const beforeLast = times.at(-2);
    const index =
      beforeLast !== undefined && time - beforeLast < MIN_SPACING_S ? this.length - 1 : this.length;
    times[index] = time;
    for (const quantity of QUANTITIES) {
      const value = measured(state, quantity);
      const { mean, min, max } = bands[quantity];
      const before = mean[index] ?? null;
      // What is not measured takes nothing back, and no extreme value is lost.
      const several = before !== null && value !== null;
      min[index] = several ? Math.min(min[index] ?? before, value) : (min[index] ?? null);
      max[index] = several ? Math.max(max[index] ?? before, value) : (max[index] ?? null);
      mean[index] = value ?? before;
    }
    this.#forget(time - WINDOW_S);
  }

  /** Leaves one point before `oldest`, so that the line enters from the left edge. */
  #forget(oldest: number): void {
    const { times, bands } = this.#points;
    let count = 0;
    while (count + 1 < times.length && (times[count + 1] ?? oldest) < oldest) count += 1;
    // In batches: cutting arrays for every message is the only costly thing here.
    if (count < 64 && count < times.length / 2) return;
    times.splice(0, count);
    for (const { mean, min, max } of Object.values(bands))
      for (const column of [mean, min, max]) column.splice(0, count);
  }
}

export type Column = (number | null)[];

/** What one quantity was; `min` and `max` are null where a point is one measurement. */
interface Band {
  mean: Column;
  min: Column;
  max: Column;
}

/** Measurements over time: times (s since 1970) in order, and a place for each of them in every column. */
export interface Points {
  times: number[];
  bands: Record<Quantity, Band>;
}

export function noPoints(): Points {
  const empty = (): Band => ({ mean: [], min: [], max: [] });
  return {
    times: [],
    bands: { voltage: empty(), percentage: empty(), current: empty(), temperature: empty() },
  };
}

/** What of a battery is plotted, in this order. */
export const QUANTITIES = ["voltage", "percentage", "current", "temperature"] as const;

export type Quantity = (typeof QUANTITIES)[number];

/** A quantity in the unit that it is plotted in; `percentage` is 0 to 1 on the wire. */
function measured(state: BatteryState, quantity: Quantity): number | null {
  return inUnit(quantity, state[quantity]);
}

export function inUnit(quantity: Quantity, value: number | null): number | null {
  return value === null || quantity !== "percentage" ? value : value * 100;
}

/** A battery state without the values that the gateway does not believe: they count as not measured. */
export function believed({ state, percentage, implausible }: Battery): BatteryState | null {
  if (state === null) return null;
  const known = { ...state, percentage };
  for (const { field } of implausible) {
    const [name, place] = field.split(".");
    if (name === "power_supply_status") known.power_supply_status = 0;
    else if (name === "cell_voltage" || name === "cell_temperature")
      known[name] = known[name].map((value, index) => (index === Number(place) ? null : value));
    else if (isMeasured(name)) known[name] = null;
  }
  return known;
}

const MEASURED = ["voltage", "current", "temperature", "charge", "capacity", "design_capacity"] as const;

function isMeasured(name: string | undefined): name is (typeof MEASURED)[number] {
  return MEASURED.some((each) => each === name);
}
