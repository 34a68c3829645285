import { ClientError } from "@dock-gateway/client";

export interface ErrorWords {
  /** Replaces the gateway's title where that is not clear enough on a page. */
  title?: string;
  advice: string | null;
}

const START_SERVER =
  "Start the action server on the robot (connect_to_charging_dock_server, or dock-gateway up), then try again.";

/** Titles and advice by error code: the gateway's codes, and those of a request without an answer. */
export const ERROR_WORDS: Record<string, ErrorWords> = {
  action_server_unavailable: { title: "There is no action server", advice: START_SERVER },
  action_server_timeout: {
    title: "The action server did not answer",
    advice:
      "It may be frozen or overloaded: look at its log and restart it. A late acceptance is canceled at once.",
  },
  action_server_unresponsive: {
    title: "The action server does not answer",
    advice: "Nothing was sent. It may be frozen or overloaded: look at its log and restart it.",
  },
  alert_not_found: {
    title: "The alert is over",
    advice: "Its cause has ended; the list shows what is left.",
  },
  calibration_refused: { advice: "Nothing was changed." },
  calibration_timeout: {
    title: "The docking server did not answer",
    advice: "It may have calibrated the dock: look at its log or its parameters.",
  },
  calibration_unavailable: { advice: "Start docking_server with the controller dock_pose." },
  docks_unavailable: { advice: "Its node does not answer: look at its log and restart it." },
  cancel_rejected: { advice: "Press Stop: it also publishes zero velocity." },
  changed_meanwhile: {
    title: "Someone else has changed it",
    advice: "Nothing was changed now. Look at the new version, then decide.",
  },
  display_name_taken: {
    title: "The name is taken",
    advice: "It is another robot's name or namespace: choose a different one.",
  },
  dock_busy: {
    title: "The dock is busy with another goal",
    advice: "Wait for it to end, or cancel it and press Dock again.",
  },
  duplicate_action_server: {
    advice: "Each of them would move the robot: shut down all but one, then send the goal again.",
  },
  gateway_timeout: {
    advice: "The command may have arrived. Look at the goals before you send it again.",
  },
  gateway_unreachable: {
    advice:
      "Check that dock-gateway runs and that this computer is on its network. Nothing is sent again by itself.",
  },
  goal_not_found: {
    title: "The gateway does not know this goal",
    advice: "It may have been restarted, or the goal is too old to be kept.",
  },
  goal_rejected: {
    title: "The action server rejected the goal",
    advice: "The reason is also in the action server's log and on /diagnostics.",
  },
  goal_terminal: { title: "The goal had already ended", advice: null },
  internal_error: {
    title: "The gateway made a mistake",
    advice: "This is a bug in dock-gateway; its log says more. Please report it.",
  },
  invalid_login: {
    title: "The name or the password is wrong",
    advice: "Or an admin has disabled this user.",
  },
  invalid_token: {
    title: "The login has ended, or the token is not valid",
    advice: "Log in again. A token may be mistyped, revoked or expired: ask an admin for another one.",
  },
  invalid_field: { title: "A value is not valid", advice: null },
  limit_reached: {
    title: "There is no room for another one",
    advice: "Remove one that is no longer in use. For labels: clear the name and groups of such robots.",
  },
  last_admin: {
    title: "This is the last admin",
    advice: "Add another admin first.",
  },
  not_authenticated: { title: "You are not logged in", advice: "Log in, then try again." },
  origin_not_allowed: {
    advice:
      "Open the dashboard at the gateway's own address, or allow this one in DOCK_GATEWAY_ALLOWED_ORIGINS.",
  },
  wrong_password: { title: "The old password is wrong", advice: null },
  host_not_allowed: { advice: "Add the name to DOCK_GATEWAY_ALLOWED_HOSTS." },
  role_required: { advice: "Somebody with that role can do it. An admin can give you another role." },
  too_many_logins: {
    title: "Too many logins have failed",
    advice: "Each failed one makes the next one wait longer.",
  },
  ros_unavailable: {
    title: "The gateway has lost ROS",
    advice: "Restart dock-gateway; its log says why the ROS thread ended.",
  },
  history_unavailable: {
    title: "The history does not answer",
    advice: "Look at /readyz of the gateway for what its database says. Running goals go on.",
  },
  stop_latched: {
    title: "A stop is latched",
    advice: "Check that the area is clear, release the stop above, then send the goal again.",
  },
  stopped: {
    title: "A stop came first",
    advice: "The goal was not sent. Send it again once the robot may move.",
  },
  shutting_down: { advice: "Wait until it is back; nothing is sent again by itself." },
  parameters_refused: { advice: "None of them was changed." },
  parameters_timeout: {
    title: "The node does not answer",
    advice: "It may be busy, or frozen: look at its log. If parameters were to be set, read them again.",
  },
  service_gone: {
    title: "The service has left",
    advice: "Its node ended during the call, which it may have carried out.",
  },
  service_timeout: { advice: "It may still carry out the call: look at the robot before calling it again." },
  token_exists: {
    title: "There is a token of this name",
    advice: "Choose a different name, or revoke that token first.",
  },
  token_not_found: { title: "The token does not exist any more", advice: null },
  too_many_requests: { advice: "Too many goals wait for an answer. Try again in some seconds." },
  wrong_topic_type: {
    title: "The battery topic is of another type",
    advice:
      "The alert names the type and the node that uses it. Set DOCK_GATEWAY_BATTERY_TOPIC to another topic.",
  },
};

/** Adds the words of an extension for its errors, by code. Called once, before anything is shown. */
export function addErrorWords(words: Readonly<Record<string, ErrorWords>>): void {
  Object.assign(ERROR_WORDS, words);
}

/** What went wrong, in a few words. */
export function titleOf(error: ClientError): string {
  return ERROR_WORDS[error.code]?.title ?? error.title;
}

/** What can be done about it. */
export function adviceFor(code: string): string | null {
  return ERROR_WORDS[code]?.advice ?? null;
}

export function toClientError(error: unknown): ClientError {
  return error instanceof ClientError
    ? error
    : new ClientError("page_error", "This page made a mistake", String(error));
}
