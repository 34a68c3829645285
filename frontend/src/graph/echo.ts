import type { ConnectionInput, components } from "@dock-gateway/client";
import { type Connection, initialConnection, nextConnection } from "../stream/connection";
import { shortest } from "../ui/numbers";

/** What `/ws/topics` sends. */
export type EchoEvent = components["schemas"]["EchoEvent"];
export type EchoMessage = components["schemas"]["MessageEvent"];
type EchoRate = components["schemas"]["RateEvent"];

export interface EchoState {
  connection: Connection;
  /** What is missing to read the messages, as the gateway puts it. */
  hint: string | null;
  latest: EchoMessage | null;
  /** The message at which the reader paused. */
  held: EchoMessage | null;
  rate: EchoRate | null;
}

export type EchoInput = { now: number } & (
  | { kind: "event"; event: EchoEvent }
  | { kind: "connection"; input: ConnectionInput }
  | { kind: "pause" }
  | { kind: "go on" }
);

export function initialEcho(now: number): EchoState {
  return { connection: initialConnection(now), hint: null, latest: null, held: null, rate: null };
}

/** The state after what has come; the same object where nothing changed. */
export function reduceEcho(state: EchoState, input: EchoInput): EchoState {
  switch (input.kind) {
    case "event":
      return take(state, input.event, input.now);
    case "connection": {
      const connection = nextConnection(state.connection, input.input, input.now);
      if (connection === state.connection) return state;
      // A rate of the past is none.
      return { ...state, connection, rate: connection.phase === "live" ? state.rate : null };
    }
    case "pause":
      return { ...state, held: state.latest };
    case "go on":
      return { ...state, held: null };
  }
}

function take(state: EchoState, event: EchoEvent, now: number): EchoState {
  switch (event.type) {
    case "topic": {
      const connection = nextConnection(state.connection, { kind: "snapshot" }, now);
      return {
        ...state,
        connection,
        hint: event.installed ? null : (event.hint ?? "Its package is missing."),
      };
    }
    case "message":
      return { ...state, latest: event };
    case "rate":
      return { ...state, rate: event };
    default:
      return state;
  }
}

/** What was left out of a message: `ranges has 720 items`. */
export function describeCuts({ lengths }: EchoMessage): string {
  return Object.entries(lengths)
    .map(([path, length]) => `${path} has ${length} items`)
    .join(", ");
}

/** `12.5 Hz`, `0.5 Hz`. */
export function formatRate(hz: number): string {
  return `${shortest(hz >= 100 ? Math.round(hz) : Number(hz.toPrecision(3)), 20)} Hz`;
}

/** `640 B/s`, `1.2 kB/s`, `34 MB/s`. */
export function formatBytes(bytesPerSecond: number): string {
  let [amount, unit] = [bytesPerSecond, "B"];
  for (const larger of ["kB", "MB", "GB"]) {
    if (amount < 1000) break;
    [amount, unit] = [amount / 1000, larger];
  }
  return `${shortest(amount >= 100 || unit === "B" ? Math.round(amount) : Number(amount.toPrecision(2)), 20)} ${unit}/s`;
}
