import type { Fault } from "../api/types";

export interface FaultWords {
  fault: Fault;
  name: string;
  effect: string;
}

/** What can be made to go wrong, and what comes of it. */
export const FAULTS: readonly FaultWords[] = [
  {
    fault: "dead_charger",
    name: "Dead charger",
    effect: "Contact, but no current: docking retries, then gives up with failed_to_charge.",
  },
  {
    fault: "occluded_marker",
    name: "Occluded marker",
    effect: "The camera does not see the dock: failed_to_detect_dock, or lost_marker on the way.",
  },
  {
    fault: "stuck_wheel",
    name: "Stuck wheel",
    effect: "The left wheel does not turn, until the base switches its motors off: blocked.",
  },
  {
    fault: "silent_battery",
    name: "Silent battery",
    effect: "No battery messages: the wheels stand still, and after a time battery_lost.",
  },
  {
    fault: "percentage_0_to_100",
    name: "Percentage 0 to 100",
    effect: "The battery driver counts to 100 instead of to 1, as many in the wild do.",
  },
];
