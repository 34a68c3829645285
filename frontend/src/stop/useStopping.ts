import { useCallback } from "react";
import { whoStops } from "../access/who";
import { useFleet } from "../fleet/context";
import { stopEverywhere, stopThese } from "./everywhere";
import { announceStop } from "./notices";

/** Stops robots at once, all of them for null, and says what came of it. */
export function useStopping(): (robots: readonly string[] | null) => Promise<void> {
  const { gateway, store } = useFleet();
  return useCallback(
    async (robots) => {
      const stop = async (some: readonly string[] | null) => {
        const report = await gateway.stop(whoStops(), some ?? []);
        const [first = null, ...others] = some ?? [];
        if (others.length === 0) store.setStop(report.stop, first); // what holds for several comes as an event
        return report;
      };
      await announceStop(
        () => store.get("naming"),
        robots,
        () => (robots === null ? stopEverywhere(stop, store.get("robots")) : stopThese(stop, robots)),
      );
    },
    [gateway, store],
  );
}
