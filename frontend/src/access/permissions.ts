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
  "PUT /robots/label": "supervisor",
  "PUT /automation/rules/{rule_id}": "supervisor",
  "GET /webhooks": "supervisor",
  "GET /users": "admin",
  "GET /tokens": "admin",
  "GET /audit": "admin",
} as const satisfies Record<string, Role>;

/** A request that a command of the page sends. */
export type Command = keyof typeof NEEDED;

/** Why the user of this page may not do something, in a sentence; null where they may. */
export function whyForbidden(command: Command): string | null {
  const { principal } = session.state;
  if (principal === null) return "Your login has ended. Log in first.";
  const role = NEEDED[command];
  return ROLES.indexOf(principal.role) >= ROLES.indexOf(role)
    ? null
    : `Needs the role ${role}; you are ${principal.role}.`;
}

/** As `whyForbidden`; renders anew when somebody else has logged in. */
export function useForbidden(command: Command): string | null {
  useSession();
  return whyForbidden(command);
}
