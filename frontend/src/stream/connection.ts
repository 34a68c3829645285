import type { ConnectionInput } from "@dock-gateway/client";

/** What is known about the connection to the gateway. `live` only after a snapshot has come. */
export type ConnectionPhase = "connecting" | "live" | "reconnecting" | "gone";

export interface Connection {
  phase: ConnectionPhase;
  /** When the phase began, in this computer's time. */
  since: number;
  /** Why the gateway closed, in its own words. */
  reason: string | null;
}

/** Without a connection for this long, "reconnecting" becomes "gone". It goes on trying. */
export const GONE_AFTER_MS = 10_000;

export function initialConnection(now: number): Connection {
  return { phase: "connecting", since: now, reason: null };
}

/** The state machine of the connection: pure, and the same object where nothing changed. */
export function nextConnection(connection: Connection, input: ConnectionInput, now: number): Connection {
  switch (input.kind) {
    case "snapshot":
      return connection.phase === "live" ? connection : { phase: "live", since: now, reason: null };
    case "closing":
      return { phase: "reconnecting", since: now, reason: input.reason };
    case "closed":
      return connection.phase === "live" ? { phase: "reconnecting", since: now, reason: null } : connection;
    case "tick": {
      const waiting = connection.phase === "connecting" || connection.phase === "reconnecting";
      return waiting && now - connection.since >= GONE_AFTER_MS
        ? { ...connection, phase: "gone" }
        : connection;
    }
  }
}
