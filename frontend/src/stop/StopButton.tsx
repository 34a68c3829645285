import { Button, Group, Kbd } from "@mantine/core";
import { useHotkeys } from "@mantine/hooks";
import { useCallback, useEffect } from "react";
import { useFleet, useFleetLive, useFleetTopic } from "../fleet/context";
import { useCommand } from "../ui/useCommand";
import { stopEverywhere } from "./everywhere";
import { heldStops } from "./held";
import { CHORD, DoubleEscape } from "./keys";
import { showFailed, showRecovered, showStopped, showStopping } from "./notices";
import classes from "./stop.module.css";
import { whoStops } from "./who";

/**
 * Stops every robot, and keeps them stopped. Enabled always: also while disconnected, while a Stop is under way, and in
 * dialogs.
 */
export function StopButton() {
  const { gateway, gatewayOf, store } = useFleet();
  const live = useFleetLive();
  const stop = useFleetTopic("stop");
  const { mutate, isPending } = useCommand(() => {
    showStopping(store.get("naming"));
    return stopEverywhere(async (robot) => {
      const report = await (robot === null ? gateway : gatewayOf(robot)).stop(whoStops());
      store.setStop(report.stop, robot);
      return report;
    }, store.get("robots"));
  });
  const press = useCallback(
    () =>
      mutate(undefined, {
        onSuccess: (report) => showStopped(report, store.get("naming")),
        onError: (error) => showFailed(error, store.get("naming")),
      }),
    [mutate, store],
  );
  useHotkeys([[CHORD, press]], [], true);

  useEffect(() => {
    const twice = new DoubleEscape();
    const hear = (event: KeyboardEvent) => {
      if (twice.press(event)) press();
    };
    // Before anything that Escape closes can keep the key to itself.
    window.addEventListener("keydown", hear, true);
    return () => window.removeEventListener("keydown", hear, true);
  }, [press]);

  useEffect(() => {
    if (!live) return;
    const held = heldStops(stop, store.get("robots"));
    showRecovered(
      held.flatMap(({ holds }) => holds),
      store.get("naming"),
    );
  }, [live, stop, store]);

  return (
    <Group gap="xs" wrap="nowrap">
      <Group gap={4} wrap="nowrap" visibleFrom="md" aria-hidden="true">
        <Kbd>Esc</Kbd>
        <Kbd>Esc</Kbd>
      </Group>
      <Button
        size="lg"
        color="red"
        className={classes.stop}
        data-stopping={isPending || undefined}
        aria-keyshortcuts="Control+Shift+X"
        title="Zero velocity at once, every goal is canceled, and none is sent until the stop is released (Esc twice, or Ctrl+Shift+X)"
        onClick={press}
      >
        Stop
      </Button>
    </Group>
  );
}
