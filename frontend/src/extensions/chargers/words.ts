import type { Naming } from "../../fleet/names";
import type { DockState, SharedDock } from "./requests";

export const STATES: Record<DockState, { words: string; color: string }> = {
  free: { words: "Free", color: "green" },
  reserved: { words: "Reserved", color: "blue" },
  occupied: { words: "Occupied", color: "blue" },
  occupied_by_unknown: { words: "Occupied", color: "orange" },
  no_contact: { words: "No contact", color: "red" },
  out_of_order: { words: "Out of order", color: "red" },
};

/** Who has the dock, in a sentence; what to do about it where somebody has to. */
export function holderWords({ state, robot, since_at, note }: SharedDock, naming: Naming): string {
  const who = robot === null ? "Another robot" : naming.nameOf(robot);
  switch (state) {
    case "free":
      return "No robot has it.";
    case "reserved":
      return `${who} is on its way.`;
    case "occupied":
      return `${who} stands here.`;
    case "occupied_by_unknown":
      return "A robot without a gateway stands here. Say so when it has left.";
    case "no_contact":
      return `${who} has it, and is not heard. Look where it is.`;
    case "out_of_order": {
      const why = note === null ? "No robot is sent here." : `No robot is sent here: ${note}.`;
      return since_at === null ? why : `${why} ${who} has it.`;
    }
  }
}

/** Whether a person can say that nobody stands there. */
export function canBeCleared({ since_at, state }: SharedDock): boolean {
  return since_at !== null && state !== "reserved";
}

/** What is wrong with the name of a dock; undefined if nothing is. */
export function nameError(name: string, taken: readonly string[]): string | undefined {
  if (taken.includes(name.trim())) return "This dock is shared already.";
  return /^[A-Za-z0-9_][A-Za-z0-9_.-]{0,59}$/.test(name.trim())
    ? undefined
    : "Type the dock_id of the docking servers: letters, digits, _ . and -";
}
