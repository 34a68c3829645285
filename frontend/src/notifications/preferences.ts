import { useSyncExternalStore } from "react";
import { ALL_ROBOTS, type RobotChoice } from "../fleet/robotChoice";

/** How this browser announces alerts, and which. */
export interface Preferences {
  /** A notification of the operating system. */
  desktop: boolean;
  sound: boolean;
  warnings: boolean;
  robots: RobotChoice;
}

const KEY = "dock-gateway-announcements";
const QUIET: Preferences = { desktop: false, sound: false, warnings: true, robots: ALL_ROBOTS };
const listeners = new Set<() => void>();
let current: Preferences | null = null;

export function preferences(): Preferences {
  current ??= stored();
  return current;
}

/** Kept in this browser, also for its other tabs. */
export function setPreferences(change: Partial<Preferences>): void {
  current = { ...preferences(), ...change };
  try {
    localStorage.setItem(KEY, JSON.stringify(current));
  } catch {
    // Storage is blocked: it holds until the page is closed.
  }
  for (const listener of listeners) listener();
}

/** Renders anew when they change. */
export function usePreferences(): Preferences {
  return useSyncExternalStore(subscribe, preferences);
}

function stored(): Preferences {
  try {
    return read(JSON.parse(localStorage.getItem(KEY) ?? "{}"));
  } catch {
    return QUIET;
  }
}

/** What is stored may be of another version, or damaged. */
function read(value: unknown): Preferences {
  const { desktop, sound, warnings, robots } = Object(value) as Record<string, unknown>;
  return {
    desktop: desktop === true,
    sound: sound === true,
    warnings: warnings !== false,
    robots: readRobots(robots),
  };
}

function readRobots(value: unknown): RobotChoice {
  const { all, names, groups } = Object(value) as Record<string, unknown>;
  return all === false ? { all, names: texts(names), groups: texts(groups) } : ALL_ROBOTS;
}

function texts(value: unknown): string[] {
  return Array.isArray(value) ? value.filter((each) => typeof each === "string") : [];
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
