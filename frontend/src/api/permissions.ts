import { OPERATIONS } from "./operations.gen";
import { type Role, session, useSession } from "./session";

/** Each role includes those before it. */
export const ROLES: readonly Role[] = ["viewer", "operator", "supervisor", "admin"];

/** A request that may need more than a login. */
export type Command = keyof typeof OPERATIONS;

/** Why the user of this page may not do something, in a sentence; null where they may. */
export function whyForbidden(command: Command): string | null {
  const { principal } = session.state;
  if (principal === null) return "Your login has ended. Log in first.";
  const { role, everyRobot } = OPERATIONS[command];
  if (ROLES.indexOf(principal.role) < ROLES.indexOf(role))
    return `Needs the role ${role}; you are ${principal.role}.`;
  const limited = principal.robots.length + principal.actions.length > 0;
  return limited && everyRobot ? "This is about every robot, and your access is limited to some." : null;
}

/** As `whyForbidden`; re-renders when somebody else has logged in. */
export function useForbidden(command: Command): string | null {
  useSession();
  return whyForbidden(command);
}
