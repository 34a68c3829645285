import { Button, Group, Kbd } from "@mantine/core";
import { useHotkeys } from "@mantine/hooks";
import { notifications } from "@mantine/notifications";
import type { CommandError } from "../api/errors";
import type { StopReport } from "../api/types";
import { useServices } from "../store/context";
import { useCommand } from "../ui/useCommand";
import classes from "./layout.module.css";

const SHORTCUT = "ctrl+shift+X";

/** Stops the robot. Enabled always: also while disconnected, while a Stop is under way, and in dialogs. */
export function StopButton() {
  const { gateway } = useServices();
  const stop = useCommand(() => gateway.stop());
  const press = () => stop.mutate(undefined, { onSuccess: showStopped, onError: showFailed });
  useHotkeys([[SHORTCUT, press]], [], true);

  return (
    <Group gap="xs" wrap="nowrap">
      <Group gap={4} wrap="nowrap" visibleFrom="md" aria-hidden="true">
        <Kbd>Ctrl</Kbd>
        <Kbd>Shift</Kbd>
        <Kbd>X</Kbd>
      </Group>
      <Button
        size="lg"
        color="red"
        className={classes.stop}
        aria-keyshortcuts="Control+Shift+X"
        title="Zero velocity at once, and every goal is canceled (Ctrl+Shift+X)"
        onClick={press}
      >
        Stop
      </Button>
    </Group>
  );
}

const STOP_NOTICE = "stop";

function show(notice: { color: string; title: string; message: string; autoClose: number | false }): void {
  notifications.hide(STOP_NOTICE);
  notifications.show({ id: STOP_NOTICE, closeButtonProps: { "aria-label": "Dismiss" }, ...notice });
}

function showStopped({ canceling, failed }: StopReport): void {
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
  show({ color: "green", title: "Stopped", message: `Zero velocity was sent. ${goals}`, autoClose: 8000 });
}

function showFailed(error: CommandError): void {
  show({
    color: "red",
    title: "Stop did not get through",
    message: `Use the robot's own emergency stop if it moves. ${error.title} (${error.code}): ${error.detail}`,
    autoClose: false,
  });
}
