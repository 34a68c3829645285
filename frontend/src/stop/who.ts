import { keep, readKept } from "../ui/kept";

const KEY = "dock-gateway-name";
const NOBODY = "the dashboard";
export const MAX_NAME = 60;

/** The name that was given on this computer; empty where none was. */
export function ownName(): string {
  return readKept(KEY) ?? "";
}

export function setOwnName(name: string): void {
  keep(KEY, name.slice(0, MAX_NAME));
}

/** Who stops the robot, as others are told. */
export function whoStops(): string {
  return ownName().trim() || NOBODY;
}
