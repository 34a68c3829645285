const KEY = "dock-gateway-name";
const NOBODY = "the dashboard";
export const MAX_NAME = 60;

/** The name that was given on this computer; empty where none was. */
export function ownName(): string {
  try {
    return localStorage.getItem(KEY) ?? "";
  } catch {
    return "";
  }
}

export function setOwnName(name: string): void {
  try {
    localStorage.setItem(KEY, name.slice(0, MAX_NAME));
  } catch {
    // Storage is blocked: it holds for nobody to remember.
  }
}

/** Who stops the robot, as others are told. */
export function whoStops(): string {
  return ownName().trim() || NOBODY;
}
