import { notifications, notificationsStore } from "@mantine/notifications";
import type { CommandError } from "../api/errors";
import type { StopReport } from "../api/types";
import type { Naming } from "../fleet/names";

const NOTICE = "stop ";

interface Notice {
  color: string;
  title: string;
  message: string;
  autoClose: number | false;
  loading?: boolean;
  /** It is replaced once the gateway has said again what is stopped. */
  "data-undelivered"?: true;
}

/**
 * Shows what became of a Stop. It replaces what was said before of the same robot, and of every robot where it is about all.
 *
 * @param robot Null for all robots.
 */
function show(robot: string | null, notice: Notice): void {
  const id = idOf(robot);
  for (const { id: shown } of notificationsStore.getState().notifications)
    if (shown !== undefined && (robot === null ? shown.startsWith(NOTICE) : shown === id))
      notifications.hide(shown);
  notifications.show({ id, closeButtonProps: { "aria-label": "Dismiss" }, ...notice });
}

function idOf(robot: string | null): string {
  return `${NOTICE}${robot ?? ""}`;
}

/** At once, before anybody has answered. */
export function showStopping(naming: Naming, robot: string | null = null): void {
  show(robot, {
    color: "red",
    title: robot === null ? "Stopping …" : `Stopping ${naming.fullNameOf(robot)} …`,
    message: "Sent to the gateway.",
    autoClose: false,
    loading: true,
  });
}

export function showStopped(
  { canceling, failed, unconfirmed, warning }: StopReport,
  naming: Naming,
  robot: string | null = null,
): void {
  const warned = warning === null ? "" : ` Warning: ${warning.detail} (${warning.code}).`;
  if (failed.length > 0) {
    const unreached = failed.some(({ robot }) => robot !== null);
    const failures = failed.map((failure) => {
      const { action_name, robot, detail, code } = failure;
      return `${action_name ?? naming.fullNameOf(robot ?? "/")}: ${detail} (${code})`;
    });
    show(robot, {
      color: "red",
      title: unreached
        ? "Not every robot was told to stand still"
        : "Zero velocity was sent, but not every goal is canceled",
      message: `${failures.join("; ")}. Use the robot's own emergency stop if it moves.${warned}`,
      autoClose: false,
    });
    return;
  }
  const goals =
    canceling.length === 0
      ? "No goal was running."
      : canceling.length === 1
        ? "One goal is being canceled."
        : `${canceling.length} goals are being canceled.`;
  const waiting = unconfirmed.length === 0 ? goals : `Not answered yet: ${unconfirmed.join(", ")}; retrying.`;
  const stopped = robot === null ? "Stopped" : `Stopped ${naming.fullNameOf(robot)}`;
  show(robot, {
    color: unconfirmed.length === 0 && warning === null ? "green" : "orange",
    title: warning === null ? stopped : `${stopped}, with a warning`,
    message: `Zero velocity was sent. ${waiting}${warned}`,
    autoClose: warning === null ? 8000 : false,
  });
}

/** @param robot The one that was to stop; null for all robots. */
export function showFailed(error: CommandError, naming: Naming, robot: string | null = null): void {
  show(robot, {
    color: "red",
    title: `Stop was NOT delivered to ${robot === null ? "any robot" : naming.fullNameOf(robot)}`,
    message: `Use the robot's own emergency stop if it moves. ${error.title} (${error.code}): ${error.detail}`,
    autoClose: false,
    "data-undelivered": true,
  });
}

/**
 * Replaces the notices of failed Stops once the gateway has said again what is stopped.
 *
 * @param stopped The robots that a stop holds.
 */
export function showRecovered(stopped: readonly string[], naming: Naming): void {
  const { notifications: shown } = notificationsStore.getState();
  if (!shown.some((notice) => notice["data-undelivered"])) return;
  show(null, {
    color: "orange",
    title: "The gateway answers again",
    message:
      stopped.length > 0
        ? `Stopped: ${stopped.map((robot) => naming.fullNameOf(robot)).join(", ")}.`
        : "No robot is stopped. Press Stop again if it is still needed.",
    autoClose: 8000,
  });
}
