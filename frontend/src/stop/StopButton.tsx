import { Button, Group, Kbd } from "@mantine/core";
import { useCallback, useEffect, useState } from "react";
import { useFleet, useFleetLive, useFleetTopic } from "../fleet/context";
import { useStopping } from "./everywhere";
import { heldStops } from "./held";
import { useStopKeys } from "./keys";
import { showRecovered } from "./notices";
import classes from "./stop.module.css";

/**
 * Stops every robot, and keeps them stopped. Enabled always: also while disconnected, while a Stop is under way, and in
 * dialogs.
 */
export function StopButton() {
  const { store } = useFleet();
  const live = useFleetLive();
  const stop = useFleetTopic("stop");
  const stopNow = useStopping();
  const [underWay, setUnderWay] = useState(0);
  const press = useCallback(() => {
    setUnderWay((count) => count + 1);
    void stopNow(null).finally(() => setUnderWay((count) => count - 1));
  }, [stopNow]);
  useStopKeys(press);

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
      <Group gap={4} wrap="nowrap" className={classes.keys ?? ""} aria-hidden="true">
        <Kbd>Esc</Kbd>
        <Kbd>Esc</Kbd>
      </Group>
      <Button
        size="lg"
        color="red"
        className={classes.stop}
        data-stopping={underWay > 0 || undefined}
        aria-keyshortcuts="Control+Shift+X"
        title="Zero velocity at once, every goal is canceled, and none is sent until the stop is released (Esc twice, or Ctrl+Shift+X)"
        onClick={press}
      >
        Stop
      </Button>
    </Group>
  );
}
