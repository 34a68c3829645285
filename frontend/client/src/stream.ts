import ReconnectingWebSocket, { type Options } from "partysocket/ws";
import type { GatewayEvent } from "./types.ts";

/** Heartbeats come every 5 s: after this silence the connection is dead even though TCP has not noticed. */
export const SILENCE_MS = 7_000;

const WATCH_INTERVAL_MS = 500;
/** The gateway closes a stream with it when the token is no longer valid. */
const INVALID_TOKEN = 4401;

export type ConnectionInput =
  | { kind: "snapshot" }
  | { kind: "closing"; reason: string }
  /** `refused`: it was not opened, or its login has ended. A page does not see which, or why. */
  | { kind: "closed"; refused?: boolean }
  | { kind: "tick" };

export interface StreamHandlers {
  onEvent(event: GatewayEvent): void;
  onConnection(input: ConnectionInput): void;
}

export interface StreamOptions extends Options {
  /** Awaited before each connection; gives the ticket that it needs, if any. It rejects if there is to be none yet. */
  before?: () => Promise<string | undefined>;
  /** The id of an event to go on after. */
  after?: string;
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

/** Reads events until it is closed; reconnects by itself, and goes on after the last event. */
export class EventStream {
  readonly #socket: ReconnectingWebSocket;
  readonly #watch: ReturnType<typeof setInterval>;

  constructor(url: string, handlers: StreamHandlers, { before, after, ...options }: StreamOptions = {}) {
    const merged = Object.create(backoff, Object.getOwnPropertyDescriptors(options)) as Options;
    const position = new Position(url, after);
    const address = async () => position.resume(await before?.());
    const socket = new ReconnectingWebSocket(address, null, merged);
    let lastHeard = performance.now();
    let opened = false;

    socket.addEventListener("open", () => {
      lastHeard = performance.now();
      opened = true;
    });
    socket.addEventListener("close", ({ code }) => {
      const refused = socket.shouldReconnect && (code === INVALID_TOKEN || !opened);
      opened = false;
      handlers.onConnection({ kind: "closed", refused });
    });
    socket.addEventListener("message", (message) => {
      lastHeard = performance.now();
      const event = parse(message.data);
      if (event === null) return;
      position.take(event);
      handlers.onEvent(event);
      if (event.type === "snapshot" || event.type === "resumed") handlers.onConnection({ kind: "snapshot" });
      if (event.type === "closing") handlers.onConnection({ kind: "closing", reason: event.reason });
    });
    this.#watch = setInterval(() => {
      handlers.onConnection({ kind: "tick" });
      if (this.connected && performance.now() - lastHeard >= SILENCE_MS) {
        lastHeard = performance.now();
        socket.reconnect();
      }
    }, WATCH_INTERVAL_MS);
    this.#socket = socket;
  }

  get connected(): boolean {
    return this.#socket.readyState === this.#socket.OPEN;
  }

  /** Connects again, at once. */
  reconnect(): void {
    this.#socket.reconnect();
  }

  close(): void {
    clearInterval(this.#watch);
    this.#socket.close();
  }
}

/** The last event that was read, to go on after. Ids sort as text. */
class Position {
  readonly #url: URL;
  #after: string;

  constructor(url: string, after = "") {
    this.#url = new URL(url);
    this.#after = after;
  }

  take(event: GatewayEvent): void {
    // Velocities are not kept for those who come back.
    const id = "id" in event && event.type !== "cmd_vel" ? event.id : null;
    if (id !== null && id > this.#after) this.#after = id;
    // The past is gone; a snapshot follows.
    if (event.type === "gap") this.#after = "";
  }

  resume(ticket: string | undefined): string {
    const url = new URL(this.#url);
    if (this.#after !== "") url.searchParams.set("after", this.#after);
    if (ticket !== undefined) url.searchParams.set("ticket", ticket);
    return url.href;
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
