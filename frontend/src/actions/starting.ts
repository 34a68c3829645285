import type { Json } from "../api/jsonSchema";

/** What a form begins with where the defaults alone show nothing: an order that can be watched, a battery that charges. */
const STARTING: Record<string, Json> = {
  "action_tutorials_interfaces/action/ConnectToChargingDock": {
    desired_battery_state: { power_supply_status: "CHARGING" },
  },
  "action_tutorials_interfaces/action/Fibonacci": { order: 10 },
  "test_msgs/action/Fibonacci": { order: 10 },
};

export function startingMessage(type: string): Json {
  return STARTING[type] ?? {};
}
