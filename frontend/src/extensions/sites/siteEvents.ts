import type { GatewayEvent } from "@dock-gateway/client";
import { hubName } from "./hub";

/** An event of a site with the names of the hub. */
export function atHub(event: GatewayEvent, site: string): GatewayEvent {
  if (event.type === "scenes") return { ...event, scenes: renamed(event.scenes, site) };
  if (event.type === "maps") return { ...event, maps: renamed(event.maps, site) };
  return event;
}

function renamed<Value>(known: Record<string, Value>, site: string): Record<string, Value> {
  return Object.fromEntries(Object.entries(known).map(([name, value]) => [hubName(site, name), value]));
}
