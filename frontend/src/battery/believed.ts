import type { BatteryState, Implausible } from "../api/types";
import { fixed } from "../ui/numbers";

interface Sent {
  /** As it was sent. */
  state: BatteryState;
  /** What the gateway believes of the charge, 0 to 1. Events of older gateways do not have it. */
  percentage?: number | null;
  implausible?: readonly Implausible[];
}

/** A battery state as far as the gateway believes it: what cannot be right is as if it were not measured. */
export function believed({ state, percentage, implausible = [] }: Sent): BatteryState {
  const known = { ...state, percentage: percentage === undefined ? state.percentage : percentage };
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

/** `percentage is 12, but should be 0 to 1` */
export function implausibleWords({ field, value, expected }: Implausible): string {
  const number = typeof value === "number" ? shortest(value) : value;
  return `${field} is ${number}, but should be ${expected}`;
}

function shortest(value: number): string {
  return Math.abs(value) < 1e6 ? fixed(value, 3).replace(/\.?0+$/, "") : value.toPrecision(6);
}
