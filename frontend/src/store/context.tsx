import type { Scene } from "@dock-gateway/client";
import { createContext, type ReactNode, useCallback, useContext, useSyncExternalStore } from "react";
import type { Gateway } from "../api/client";
import { useSession } from "../api/session";
import { ClockProvider, useAtTime } from "../clock/clock";
import type { BatterySeries } from "./batterySeries";
import type { RobotLayer } from "./layers";
import type { SceneBuffer } from "./sceneBuffer";
import type { Store, Topic, Topics } from "./store";
import { RENDER_INTERVAL_MS } from "./streamStore";

/** What there is for one robot. */
export interface Services {
  /** Its namespace; null for the one that the gateway is configured for. */
  robot: string | null;
  gateway: Gateway;
  store: Store;
  series: BatterySeries;
  scene: SceneBuffer;
  /** The layers of extensions, the lowest first. */
  layers: readonly RobotLayer[];
}

const ServicesContext = createContext<Services | null>(null);

export function ServicesProvider({ value, children }: { value: Services; children: ReactNode }) {
  return (
    <ServicesContext.Provider value={value}>
      <ClockProvider value={value.store}>{children}</ClockProvider>
    </ServicesContext.Provider>
  );
}

export function useServices(): Services {
  const services = useContext(ServicesContext);
  if (services === null) throw new Error("ServicesProvider is missing");
  return services;
}

/** A topic of the store; re-renders when that topic changes, at most five times a second. */
export function useTopic<T extends Topic>(topic: T): Topics[T] {
  return useTopicPart(topic, (value) => value);
}

/**
 * What is read off a topic of the store; re-renders only where that is another, which for texts and numbers is less often
 * than the topic changes.
 */
export function useTopicPart<T extends Topic, Part>(topic: T, read: (value: Topics[T]) => Part): Part {
  const { store } = useServices();
  const subscribe = useCallback((listener: () => void) => store.subscribe(topic, listener), [store, topic]);
  return useSyncExternalStore(subscribe, () => read(store.get(topic)));
}

/** Whether what is shown is what the gateway says now. Re-renders when the login changes, too. */
export function useLive(): boolean {
  const { principal } = useSession();
  return useTopicPart("connection", ({ phase }) => phase === "live") && principal !== null;
}

const INTERVAL_MS = 400;

/** What words and buttons read off the latest scene, re-rendered where it is another; the picture does without React. */
export function useScene<Part>(read: (scene: Scene | null) => Part): Part {
  const { scene: buffer } = useServices();
  return useAtTime(() => read(buffer.latest), INTERVAL_MS);
}

/** What words read off the layers of the picture, re-rendered where it is another. */
export function useLayers<Part extends string | number | boolean>(
  read: (layers: readonly RobotLayer[]) => Part,
): Part {
  const { layers } = useServices();
  return useAtTime(() => read(layers), INTERVAL_MS);
}

/**
 * How current the data of a source is. `none`: nothing has come yet; `stale`: nothing has come for longer than is usual;
 * `offline`: the gateway is not connected, so that it is unknown.
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
type Source = "battery" | "velocity" | "scene";

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
