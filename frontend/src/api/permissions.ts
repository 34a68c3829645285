import { type Role, session, useSession } from "./session";

/** Each role includes those before it. */
export const ROLES: readonly Role[] = ["viewer", "operator", "supervisor", "admin"];

/** The roles that commands of the page need; `x-role` of the OpenAPI document, as a test makes sure. */
export const NEEDED = {
  "POST /dock": "operator",
  "POST /undock": "operator",
  "POST /actions/{name}/goals": "operator",
  "POST /goals/{goal_id}/cancel": "operator",
  "POST /goals/{goal_id}/notes": "operator",
  "PUT /alerts/{alert_id}/acknowledgement": "operator",
  "POST /simulator/reset": "operator",
  "POST /simulator/place": "operator",
  "PUT /simulator/faults/{fault}": "operator",
  "DELETE /stop": "supervisor",
  "POST /battery": "supervisor",
  "POST /calibration": "supervisor",
  "PUT /robots/label": "supervisor",
  "PUT /automation/rules/{rule_id}": "supervisor",
  "GET /webhooks": "supervisor",
  "GET /users": "admin",
  "GET /people": "admin",
  "GET /tokens": "admin",
  "GET /audit": "admin",
} as const satisfies Record<string, Role>;

/** Those that are about every robot: whose access is limited to some may not send them. */
const ABOUT_EVERY_ROBOT: ReadonlySet<string> = new Set([
  "PUT /robots/label",
  "PUT /automation/rules/{rule_id}",
  "GET /webhooks",
]);

/** A request that a command of the page sends. */
export type Command = keyof typeof NEEDED;

/** Why the user of this page may not do something, in a sentence; null where they may. */
export function whyForbidden(command: Command): string | null {
  const { principal } = session.state;
  if (principal === null) return "Your login has ended. Log in first.";
  const role = NEEDED[command];
  if (ROLES.indexOf(principal.role) < ROLES.indexOf(role))
    return `Needs the role ${role}; you are ${principal.role}.`;
  const limited = principal.robots.length + principal.actions.length > 0;
  return limited && ABOUT_EVERY_ROBOT.has(command)
    ? "This is about every robot, and your access is limited to some."
    : null;
}

/** As `whyForbidden`; re-renders when somebody else has logged in. */
export function useForbidden(command: Command): string | null {
  useSession();
  return whyForbidden(command);
}
