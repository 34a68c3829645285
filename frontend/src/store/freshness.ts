import { useAtTime } from "../clock/clock";
import { useLive, useServices } from "./context";
import { RENDER_INTERVAL_MS } from "./shown";

/**
 * How current the data of a source is. `none`: nothing has come yet; `stale`: nothing has come for longer than is usual;
 * `offline`: the gateway is not connected, so that nobody knows.
 */
export type Freshness = "live" | "stale" | "none" | "offline";

/**
 * @param ageMs Since the latest message; null where none has come.
 * @param staleAfterMs The source is stale after this silence.
 */
export function freshnessOf(connected: boolean, ageMs: number | null, staleAfterMs: number): Freshness {
  if (!connected) return "offline";
  if (ageMs === null) return "none";
  return ageMs > staleAfterMs ? "stale" : "live";
}

/** A velocity command that is older is history, not what the robot does (ms). */
const VELOCITY_STALE_MS = 1000;
/** Without an event for this long the scene is history (ms). */
export const SCENE_STALE_MS = 2000;

/** The sources of one robot's data. */
export type Source = "battery" | "velocity" | "scene";

/** How current a source of this robot is; every badge and text on its page says this. */
export function useFreshness(source: Source): Freshness {
  const { store, scene } = useServices();
  const connected = useLive();
  return useAtTime((now) => {
    switch (source) {
      case "battery": {
        const { receivedAt, staleAfterS } = store.get("battery");
        return freshnessOf(connected, receivedAt === null ? null : now - receivedAt, staleAfterS * 1000);
      }
      case "velocity": {
        const { receivedAt } = store.get("cmdVel");
        return freshnessOf(connected, receivedAt === null ? null : now - receivedAt, VELOCITY_STALE_MS);
      }
      case "scene": {
        const age = scene.latest === null ? null : performance.now() - scene.arrivedAt;
        return freshnessOf(connected, age, SCENE_STALE_MS);
      }
    }
  }, RENDER_INTERVAL_MS);
}
