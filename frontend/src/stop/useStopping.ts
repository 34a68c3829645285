import { useCallback } from "react";
import { toCommandError } from "../api/errors";
import { useFleet } from "../fleet/context";
import { stopEverywhere, stopThese } from "./everywhere";
import { showFailed, showStopped, showStopping } from "./notices";
import { whoStops } from "./who";

/** Stops robots at once, all of them for null, and says what came of it. */
export function useStopping(): (robots: readonly string[] | null) => Promise<void> {
  const { gateway, gatewayOf, store } = useFleet();
  return useCallback(
    async (robots) => {
      showStopping(store.get("naming"), robots);
      const stopOne = async (robot: string | null) => {
        const report = await (robot === null ? gateway : gatewayOf(robot)).stop(whoStops());
        store.setStop(report.stop, robot);
        return report;
      };
      try {
        const report = await (robots === null
          ? stopEverywhere(stopOne, store.get("robots"))
          : stopThese(stopOne, robots));
        showStopped(report, store.get("naming"), robots);
      } catch (error) {
        showFailed(toCommandError(error), store.get("naming"), robots);
      }
    },
    [gateway, gatewayOf, store],
  );
}
