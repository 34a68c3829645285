import type { Role } from "../api/session";

export function sessionWords(sessions: number): string {
  if (sessions === 0) return "No";
  return sessions === 1 ? "In one browser" : `In ${sessions} browsers`;
}

/** What somebody with a role may do besides what those before it may. */
export const ROLE_WORDS: Record<Role, string> = {
  viewer: "Sees its robots, and may stop every robot.",
  operator: "Also docks and undocks, sends and cancels goals, adds notes, and acknowledges alerts.",
  supervisor: "Also releases stops, and changes rules, webhooks, names and groups.",
  admin: "Also adds and changes users and tokens, and reads the audit log.",
};
