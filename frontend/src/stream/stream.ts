import type { GatewayEvent } from "@dock-gateway/client";
import ReconnectingWebSocket, { type Options } from "partysocket/ws";
import { session } from "../api/session";
import { steadyNow } from "../clock/beat";
import { type ConnectionInput, SILENCE_MS } from "./connection";

const WATCH_INTERVAL_MS = 500;
/** The gateway closes a stream with it when the token is no longer valid. */
const INVALID_TOKEN = 4401;

export interface StreamHandlers {
  onEvent(event: GatewayEvent): void;
  onConnection(input: ConnectionInput): void;
}

export type StreamLocation = Pick<Location, "protocol" | "host">;

/** What a stream is about: the query of its path. */
type StreamQuery = Record<string, string | null>;

/** Where the events are, for a page at `location`; what is null is not asked for. */
export function streamUrl(location: StreamLocation, query: StreamQuery, path = "/ws/feedback"): string {
  const scheme = location.protocol === "https:" ? "wss:" : "ws:";
  const url = new URL(`${scheme}//${location.host}${path}`);
  for (const [name, value] of Object.entries(query)) if (value !== null) url.searchParams.set(name, value);
  return url.href;
}

/** Half a second, growing to eight; drawn again for each attempt, so that a hundred open pages do not return as one. */
const backoff: Options = {
  get minReconnectionDelay() {
    return 400 + Math.random() * 600;
  },
  maxReconnectionDelay: 8_000,
  reconnectionDelayGrowFactor: 1.5,
  connectionTimeout: 10_000,
  minUptime: 3_000,
  // This socket is only read. Commands go over REST; nothing may be replayed after a reconnect.
  maxEnqueuedMessages: 0,
};

/**
 * Reads events until the returned function is called; reconnects by itself, and goes on after the last event. Waits for a
 * login while one is needed.
 */
export function openStream(url: string, handlers: StreamHandlers, options: Options = {}): () => void {
  const merged = Object.create(backoff, Object.getOwnPropertyDescriptors(options)) as Options;
  const position = new Position();
  const address = () => session.loggedIn().then(() => position.resume(url));
  const socket = new ReconnectingWebSocket(address, null, merged);
  let lastHeard = steadyNow();
  let opened = false;

  socket.addEventListener("open", () => {
    lastHeard = steadyNow();
    opened = true;
  });
  socket.addEventListener("close", ({ code }) => {
    handlers.onConnection({ kind: "closed" });
    // A page is not told why a handshake was refused.
    if (socket.shouldReconnect && (code === INVALID_TOKEN || !opened)) void session.ask();
    opened = false;
  });
  socket.addEventListener("message", (message) => {
    lastHeard = steadyNow();
    const event = parse(message.data);
    if (event === null) return;
    position.take(event);
    handlers.onEvent(event);
    if (event.type === "snapshot" || event.type === "resumed") handlers.onConnection({ kind: "snapshot" });
    if (event.type === "closing") handlers.onConnection({ kind: "closing", reason: event.reason });
  });

  const watch = setInterval(() => {
    handlers.onConnection({ kind: "tick" });
    if (socket.readyState === socket.OPEN && steadyNow() - lastHeard >= SILENCE_MS) {
      lastHeard = steadyNow();
      socket.reconnect();
    }
  }, WATCH_INTERVAL_MS);
  const retryNow = () => {
    if (socket.readyState !== socket.OPEN) socket.reconnect();
  };
  // TCP would notice only later. Where the gateway is on this computer, it goes on at once.
  const tryAnew = () => socket.reconnect();
  window.addEventListener("online", retryNow);
  window.addEventListener("offline", tryAnew);
  const forget = session.subscribe(() => session.loggedOut && socket.reconnect());

  return () => {
    clearInterval(watch);
    forget();
    window.removeEventListener("online", retryNow);
    window.removeEventListener("offline", tryAnew);
    socket.close();
  };
}

/** The last event that was read, to go on after. Ids sort as text. */
class Position {
  #after = "";

  take(event: GatewayEvent): void {
    // Velocities are not kept for those who come back.
    if ("id" in event && event.type !== "cmd_vel" && event.id > this.#after) this.#after = event.id;
    // The past is gone; a snapshot follows.
    if (event.type === "gap") this.#after = "";
  }

  resume(url: string): string {
    if (this.#after === "") return url;
    const resumed = new URL(url);
    resumed.searchParams.set("after", this.#after);
    return resumed.href;
  }
}

function parse(data: unknown): GatewayEvent | null {
  if (typeof data !== "string") return null;
  try {
    const event: unknown = JSON.parse(data);
    return typeof event === "object" && event !== null && "type" in event ? (event as GatewayEvent) : null;
  } catch {
    return null;
  }
}
