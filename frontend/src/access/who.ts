import { session } from "../api/session";
import { keep, readKept } from "../ui/kept";

const KEY = "dock-gateway-name";
const NOBODY = "the dashboard";
export const MAX_NAME = 60;

/** The name of who is logged in, which the gateway uses whatever it is sent; null where nobody is. */
export function loginName(): string | null {
  return session.state.principal?.name ?? null;
}

/** The name of who is logged in, else the one that was given on this computer; empty where none was. */
export function ownName(): string {
  return loginName() ?? readKept(KEY) ?? "";
}

/** Keeps a name on this computer; not that of a login. */
export function setOwnName(name: string): void {
  if (loginName() === null) keep(KEY, name.slice(0, MAX_NAME));
}

/** Who stops the robot, as others are told. */
export function whoStops(): string {
  return ownName().trim() || NOBODY;
}
