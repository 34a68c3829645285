import type { GatewayEvent, Http } from "@dock-gateway/client";
import {
  createContext,
  type ReactNode,
  useCallback,
  useContext,
  useEffect,
  useSyncExternalStore,
} from "react";
import type { Gateway } from "../api/client";
import { type Command, useForbidden, useSession } from "../api/session";
import { ClockProvider } from "../clock/clock";
import type { OpenRobot } from "../store/openRobot";
import type { Naming } from "./names";
import type { FleetStore, FleetTopic, FleetTopics } from "./store";

/** What every page has. */
export interface FleetServices {
  http: Http;
  /** The API of the gateway that a robot or an action is of: that of its site, on a page about several sites. */
  httpOf(name: string): Http;
  /** Commands for the robot that the gateway is configured for; its Stop stops those in namespaces below, too. */
  gateway: Gateway;
  /** Commands for one robot, the configured one for null. */
  gatewayOf(robot: string | null): Gateway;
  store: FleetStore;
  /** Reads along with one robot, the configured one for null, until it is closed. */
  openRobot(robot: string | null): OpenRobot;
}

const FleetContext = createContext<FleetServices | null>(null);

export function FleetProvider({ value, children }: { value: FleetServices; children: ReactNode }) {
  return (
    <FleetContext.Provider value={value}>
      <ClockProvider value={value.store}>{children}</ClockProvider>
    </FleetContext.Provider>
  );
}

export function useFleet(): FleetServices {
  const services = useContext(FleetContext);
  if (services === null) throw new Error("FleetProvider is missing");
  return services;
}

/** A topic of the fleet's store; re-renders when that topic changes, at most five times a second. */
export function useFleetTopic<T extends FleetTopic>(topic: T): FleetTopics[T] {
  return useFleetPart(topic, (value) => value);
}

/** What is read off a topic of the fleet's store; re-renders only where that is another. */
export function useFleetPart<T extends FleetTopic, Part>(
  topic: T,
  read: (value: FleetTopics[T]) => Part,
): Part {
  const { store } = useFleet();
  const subscribe = useCallback((listener: () => void) => store.subscribe(topic, listener), [store, topic]);
  return useSyncExternalStore(subscribe, () => read(store.get(topic)));
}

/** Calls a listener with each event of a type, such as one that an extension adds. @param listener Stays the same. */
export function useFleetEvent(type: GatewayEvent["type"], listener: () => void): void {
  const { store } = useFleet();
  useEffect(() => store.onEvents((event) => event.type === type && listener()), [store, type, listener]);
}

/** Whether what is shown of all robots is what the gateway says now. Re-renders when the login changes, too. */
export function useFleetLive(): boolean {
  const { principal } = useSession();
  return useFleetPart("connection", ({ phase }) => phase === "live") && principal !== null;
}

/** The names of all robots; re-renders only when a name or a group changes. */
export function useNaming(): Naming {
  return useFleetTopic("naming");
}

export const NOT_CONNECTED = "The gateway is not connected.";

/**
 * Why a command cannot be given now, in a sentence; null where it can.
 *
 * @param ready Whether what the command needs to know has come.
 */
export function useWhyNot(command: Command, ready = true): string | null {
  const forbidden = useForbidden(command);
  const live = useFleetLive();
  return forbidden ?? (live && ready ? null : NOT_CONNECTED);
}
