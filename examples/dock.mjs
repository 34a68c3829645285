// Send the robot to its dock and watch it: `node examples/dock.mjs`, where `@dock-gateway/client` is installed.
import { Client } from "@dock-gateway/client";

const gateway = new Client();
const goal = await gateway.dock();
for await (const feedback of goal) {
  const battery = feedback.current_battery_state;
  console.log(`${battery.voltage} V, power supply status ${battery.power_supply_status}`);
}
console.log((await goal.result()).status);
