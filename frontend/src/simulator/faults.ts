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
    fault: "flickering_charge",
    name: "Flickering charge",
    effect: "The charging current comes and goes: docking retries, then gives up with failed_to_charge.",
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
    fault: "late_commands",
    name: "Late commands",
    effect: "Commands reach the wheels 0.3 s late: docking allows for it.",
  },
  {
    fault: "worn_wheel",
    name: "Worn wheel",
    effect:
      "The right wheel is 10 % smaller than the robot knows: it drives curves and measures straight lines.",
  },
  {
    fault: "wrong_detections",
    name: "Wrong detections",
    effect: "A third of the detections are somewhere else: docking leaves them out.",
  },
  {
    fault: "future_detections",
    name: "Future detections",
    effect: "The camera's clock is 0.5 s ahead: docking cannot use its detections, and says so.",
  },
  {
    fault: "repeated_odometry",
    name: "Repeated odometry",
    effect: "Odometry repeats itself for half a second in each three: docking takes that for silence.",
  },
  {
    fault: "obstacle",
    name: "Obstacle",
    effect:
      "A pillar in front of the dock: it hides the marker, and stops the robot; with collision detection, the robot waits.",
  },
  {
    fault: "hidden_beacon",
    name: "Hidden beacon",
    effect: "No infrared receiver sees the beacon: docking by infrared waits, then backs off and retries.",
  },
  {
    fault: "infrared_ghosts",
    name: "Infrared ghosts",
    effect: "A tenth of the infrared distances are random: docking leaves them out.",
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
