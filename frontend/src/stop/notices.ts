import { notifications } from "@mantine/notifications";
import type { CommandError } from "../api/errors";
import type { StopReport } from "../api/types";

const NOTICE = "stop";

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

export function showStopped({ canceling, failed, unconfirmed }: StopReport): void {
  if (failed.length > 0) {
    show({
      color: "red",
      title: "Zero velocity was sent, but not every goal is canceled",
      message: `${failed.map((failure) => `${failure.action_name}: ${failure.detail} (${failure.code})`).join("; ")}. The action server may drive on: use the robot's own emergency stop if it moves.`,
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
  const waiting =
    unconfirmed.length === 0 ? goals : `Not answered yet: ${unconfirmed.join(", ")}; asked until they do.`;
  show({
    color: unconfirmed.length === 0 ? "green" : "orange",
    title: "Stopped",
    message: `Zero velocity was sent. ${waiting}`,
    autoClose: 8000,
  });
}

export function showFailed(error: CommandError): void {
  show({
    color: "red",
    title: "Stop did not get through",
    message: `Use the robot's own emergency stop if it moves. ${error.title} (${error.code}): ${error.detail}`,
    autoClose: false,
  });
}
