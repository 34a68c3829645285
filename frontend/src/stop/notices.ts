import { notifications, notificationsStore } from "@mantine/notifications";
import type { CommandError } from "../api/errors";
import type { StopReport } from "../api/types";

const NOTICE = "stop";
const NOT_DELIVERED = "Stop was NOT delivered";

interface Notice {
  color: string;
  title: string;
  message: string;
  autoClose: number | false;
  loading?: boolean;
}

function show(notice: Notice): void {
  notifications.hide(NOTICE);
  notifications.show({ id: NOTICE, closeButtonProps: { "aria-label": "Dismiss" }, ...notice });
}

/** At once, before anybody has answered. */
export function showStopping(): void {
  show({
    color: "red",
    title: "Stopping …",
    message: "Sent to the gateway.",
    autoClose: false,
    loading: true,
  });
}

export function showStopped({ canceling, failed, unconfirmed, warning }: StopReport): void {
  const warned = warning === null ? "" : ` Warning: ${warning.detail} (${warning.code}).`;
  if (failed.length > 0) {
    const unreached = failed.some(({ robot }) => robot !== null);
    const failures = failed.map((failure) => {
      const { action_name, robot, detail, code } = failure;
      return `${action_name ?? robot}: ${detail} (${code})`;
    });
    show({
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
  show({
    color: unconfirmed.length === 0 && warning === null ? "green" : "orange",
    title: warning === null ? "Stopped" : "Stopped, with a warning",
    message: `Zero velocity was sent. ${waiting}${warned}`,
    autoClose: warning === null ? 8000 : false,
  });
}

export function showFailed(error: CommandError): void {
  show({
    color: "red",
    title: NOT_DELIVERED,
    message: `Use the robot's own emergency stop if it moves. ${error.title} (${error.code}): ${error.detail}`,
    autoClose: false,
  });
}

/**
 * Replaces the notice of a failed Stop once the gateway has said again what is stopped.
 *
 * @param stopped The robots that a stop holds.
 */
export function showRecovered(stopped: readonly string[]): void {
  const shown = notificationsStore.getState().notifications.find(({ id }) => id === NOTICE);
  if (shown?.title !== NOT_DELIVERED) return;
  show({
    color: "orange",
    title: "The gateway answers again",
    message:
      stopped.length > 0
        ? `Stopped: ${stopped.join(", ")}.`
        : "No robot is stopped. Press Stop again if it is still needed.",
    autoClose: 8000,
  });
}
