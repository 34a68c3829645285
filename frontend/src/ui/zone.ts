import { useSyncExternalStore } from "react";

/** How every time of the dashboard is shown: in the reader's zone or in UTC. */
export type Zone = "local" | "utc";

const KEY = "dock-gateway-zone";
const listeners = new Set<() => void>();
let current: Zone | null = null;

export function shownZone(): Zone {
  current ??= stored();
  return current;
}

/** Kept in this browser, also for its other tabs. */
export function setZone(zone: Zone): void {
  current = zone;
  try {
    localStorage.setItem(KEY, zone);
  } catch {
    // Storage is blocked: it holds until the page is closed.
  }
  for (const listener of listeners) listener();
}

/** Renders anew when it changes. */
export function useZone(): Zone {
  return useSyncExternalStore(subscribe, shownZone);
}

/** The name of the zone in the IANA database. */
export function zoneName(): string {
  if (shownZone() === "utc") return "UTC";
  const name = Intl.DateTimeFormat().resolvedOptions().timeZone;
  return name === undefined || name === "Etc/Unknown" ? "UTC" : name;
}

function stored(): Zone {
  try {
    return localStorage.getItem(KEY) === "utc" ? "utc" : "local";
  } catch {
    return "local";
  }
}

function subscribe(listener: () => void): () => void {
  const hear = ({ key }: StorageEvent) => {
    if (key !== KEY && key !== null) return;
    current = stored();
    listener();
  };
  listeners.add(listener);
  window.addEventListener("storage", hear);
  return () => {
    listeners.delete(listener);
    window.removeEventListener("storage", hear);
  };
}
