import { useCallback } from "react";
import { toCommandError } from "../api/errors";
import { useFleet } from "../fleet/context";
import { stopEverywhere, stopThese } from "./everywhere";
import { showFailed, showStopped, showStopping } from "./notices";
import { whoStops } from "./who";

/** Stops robots at once, all of them for null, and says what came of it. */
export function useStopping(): (robots: readonly string[] | null) => Promise<void> {
  const { gateway, store } = useFleet();
  return useCallback(
    async (robots) => {
      showStopping(store.get("naming"), robots);
      const stop = async (some: readonly string[] | null) => {
        const report = await gateway.stop(whoStops(), some ?? []);
        const [first = null, ...others] = some ?? [];
        if (others.length === 0) store.setStop(report.stop, first); // what holds for several comes as an event
        return report;
      };
      try {
        const report = await (robots === null
          ? stopEverywhere(stop, store.get("robots"))
          : stopThese(stop, robots));
        showStopped(report, store.get("naming"), robots);
      } catch (error) {
        showFailed(toCommandError(error), store.get("naming"), robots);
      }
    },
    [gateway, store],
  );
}
