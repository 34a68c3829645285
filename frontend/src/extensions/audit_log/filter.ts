import { Address, oneOf, text } from "../../ui/address";
import { sentence } from "../../ui/text";
import { ANY_TIME, type TimeRange, timeQuery, timeRange } from "../../ui/timeRange";
import type { AuditQuery, AuditRecord } from "./requests";

export type Outcome = AuditRecord["outcome"];
export const OUTCOMES: readonly Outcome[] = ["done", "refused", "failed"];

/** Which records to list; lives in the page's address. Empty is any. */
export interface AuditFilter {
  time: TimeRange;
  principal: string;
  what: string;
  robot: string;
  goalId: string;
  outcome: Outcome | null;
}

/** The ids of goals that `GET /audit` accepts. */
export const GOAL_ID = /^[0-9a-f]{8}(-?[0-9a-f]{4}){3}-?[0-9a-f]{12}$/i;

export const auditFilter = new Address<AuditFilter>({
  principal: text("principal"),
  what: text("what"),
  robot: text("robot"),
  goalId: text("goal_id", GOAL_ID),
  outcome: oneOf("outcome", OUTCOMES, null),
  time: timeRange(),
});

/** @param now In the gateway's time (ms). */
export function toQuery(filter: AuditFilter, now: number): AuditQuery {
  const named = auditFilter.write({ ...filter, time: ANY_TIME });
  return { ...Object.fromEntries(named), ...timeQuery(filter.time, now) };
}

/** What is recorded, in a few words: requests by their operation, commands of `/ws`, and remarks of the gateway. */
export const WHAT_WORDS: Readonly<Record<string, string>> = {
  stop: "Stop",
  release_stop: "Release the stop",
  dock: "Dock",
  undock: "Undock",
  send_goal: "Send a goal",
  send_action_goal: "Send a goal",
  cancel_goal: "Cancel a goal",
  log_in: "Log in",
  issue_ticket: "Get a ticket for a WebSocket",
  log_out: "Log out",
  create_token: "Create a token",
  revoke_token: "Revoke a token",
  acknowledge: "Acknowledge an alert",
  withdraw_acknowledgement: "Withdraw an acknowledgement",
  add_note: "Add a note",
  delete_note: "Delete a note",
  replace_tags: "Change tags",
  label_robot: "Name a robot",
  replace_rule: "Change a docking rule",
  remove_rule: "Remove a docking rule",
  replace_webhook: "Change a webhook",
  remove_webhook: "Remove a webhook",
  test_webhook: "Test a webhook",
  publish_battery: "Publish a battery state",
  start_publisher: "Publish battery states",
  stop_publisher: "Stop publishing battery states",
  stop_publishing: "Stop publishing battery states",
  calibrate_dock: "Calibrate a dock",
  reset_simulator: "Reset the simulator",
  place_robot: "Place the simulated robot",
  switch_fault: "Switch a simulated fault",
  export_goals: "Export goals",
  export_goal: "Export a goal",
  list_audit: "Read the audit log",
  export_audit: "Export the audit log",
  more_requests: "Requests without a valid token",
  entries_lost: "Records lost",
};

export function whatWords(what: string): string {
  return WHAT_WORDS[what] ?? sentence(what.replaceAll("_", " "));
}

export const OUTCOME_WORDS: Record<Outcome, string> = { done: "Done", refused: "Refused", failed: "Failed" };
