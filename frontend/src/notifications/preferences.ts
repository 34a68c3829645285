import { siteKey } from "../api/site";
import { ALL_ROBOTS, type RobotChoice } from "../fleet/robotChoice";
import { Kept, useKept } from "../ui/kept";

/** How this browser announces alerts, and which. */
export interface Preferences {
  /** A notification of the operating system. */
  desktop: boolean;
  sound: boolean;
  warnings: boolean;
  robots: RobotChoice;
}

const chosen = new Kept<Preferences>(siteKey("dock-gateway-announcements"), read, (value) =>
  JSON.stringify(value),
);

export function preferences(): Preferences {
  return chosen.value;
}

export function setPreferences(change: Partial<Preferences>): void {
  chosen.value = { ...chosen.value, ...change };
}

/** Re-renders when they change. */
export function usePreferences(): Preferences {
  return useKept(chosen);
}

/** What is kept may be of another version, or damaged. */
function read(text: string | null): Preferences {
  const { desktop, sound, warnings, robots } = parsed(text);
  return {
    desktop: desktop === true,
    sound: sound === true,
    warnings: warnings !== false,
    robots: readRobots(robots),
  };
}

function parsed(text: string | null): Record<string, unknown> {
  try {
    return Object(JSON.parse(text ?? "{}"));
  } catch {
    return {};
  }
}

function readRobots(value: unknown): RobotChoice {
  const { all, names, groups } = Object(value) as Record<string, unknown>;
  return all === false ? { all, names: texts(names), groups: texts(groups) } : ALL_ROBOTS;
}

function texts(value: unknown): string[] {
  return Array.isArray(value) ? value.filter((each) => typeof each === "string") : [];
}
