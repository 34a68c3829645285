import type { BatteryState, Implausible } from "../api/types";

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
