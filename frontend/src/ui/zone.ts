import { Kept, useKept } from "./kept";

/** How every time of the dashboard is shown: in the reader's zone or in UTC. */
export type Zone = "local" | "utc";

const chosen = new Kept<Zone>(
  "dock-gateway-zone",
  (text) => (text === "utc" ? "utc" : "local"),
  (zone) => zone,
);

export function shownZone(): Zone {
  return chosen.value;
}

export function setZone(zone: Zone): void {
  chosen.value = zone;
}

/** Re-renders when it changes. */
export function useZone(): Zone {
  return useKept(chosen);
}

/** The name of the zone in the IANA database. */
export function zoneName(): string {
  if (shownZone() === "utc") return "UTC";
  const name = Intl.DateTimeFormat().resolvedOptions().timeZone;
  return name === undefined || name === "Etc/Unknown" ? "UTC" : name;
}
