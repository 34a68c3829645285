import type { EventOf, GatewayEvent, Goal, Simulator, StopState } from "../api/types";
import {
  type Connection,
  type ConnectionInput,
  initialConnection,
  nextConnection,
} from "../stream/connection";
import { mergeGoals } from "./goals";
import { reduce } from "./reducer";
import { initialState, type State } from "./state";

/** What the page shows, each part with subscribers of its own. */
export interface Topics extends Omit<State, "seen"> {
  connection: Connection;
}

export type Topic = keyof Topics;

/** Subscribers are told at most this often, whatever the message rate. */
export const RENDER_INTERVAL_MS = 100;

/**
 * Holds the state, and shows it to subscribers at most ten times a second. What is shown is one moment of all topics;
 * a change of the connection is shown at once.
 */
export class Store {
  #state: State = initialState;
  #connection: Connection;
  #shown: Topics;
  #lastFlush = Number.NEGATIVE_INFINITY;
  #timer: ReturnType<typeof setTimeout> | undefined;
  readonly #listeners = new Map<Topic, Set<() => void>>();
  readonly #batteryListeners = new Set<(event: EventOf<"battery">) => void>();
  readonly #sceneListeners = new Set<(event: EventOf<"scene">) => void>();
  readonly #now: () => number;

  constructor(now: () => number = Date.now) {
    this.#now = now;
    this.#connection = initialConnection(now());
    this.#shown = this.#topics();
  }

  readonly onEvent = (event: GatewayEvent): void => {
    if (event.type === "scene") {
      for (const listener of this.#sceneListeners) listener(event);
      return;
    }
    const before = this.#state;
    this.#state = reduce(before, event, this.#now());
    if (this.#state === before) return;
    if (event.type === "battery") for (const listener of this.#batteryListeners) listener(event);
    this.#schedule();
  };

  readonly onConnection = (input: ConnectionInput): void => {
    const next = nextConnection(this.#connection, input, this.#now());
    if (next === this.#connection) return;
    this.#connection = next;
    this.#flush();
  };

  /** Takes up goals from an answer over HTTP. */
  addGoals(goals: readonly Goal[]): void {
    this.#state = mergeGoals(this.#state, goals);
    this.#schedule();
  }

  /** Takes up what an answer over HTTP says of the simulator; null where there is none. */
  readonly setSimulator = (simulator: Simulator | null): void => {
    this.#state = { ...this.#state, simulator };
    this.#schedule();
  };

  /** Takes up what an answer over HTTP says of the stop: at once, as people wait for it. */
  setStop(stop: StopState): void {
    this.#state = { ...this.#state, stop };
    this.#flush();
  }

  /** What is shown of a topic; the same object until it changes. */
  get<T extends Topic>(topic: T): Topics[T] {
    return this.#shown[topic];
  }

  subscribe(topic: Topic, listener: () => void): () => void {
    const listeners = this.#listeners.get(topic) ?? new Set();
    this.#listeners.set(topic, listeners.add(listener));
    return () => listeners.delete(listener);
  }

  /** Every battery message as it comes, unthrottled: for the plot's buffer. */
  onBattery(listener: (event: EventOf<"battery">) => void): () => void {
    this.#batteryListeners.add(listener);
    return () => this.#batteryListeners.delete(listener);
  }

  /** Every scene as it comes: for the picture, which is drawn outside of React. */
  onScene(listener: (event: EventOf<"scene">) => void): () => void {
    this.#sceneListeners.add(listener);
    return () => this.#sceneListeners.delete(listener);
  }

  /** Now, in the gateway's time (ms): what its timestamps are compared with. */
  gatewayNow(): number {
    return this.#now() - this.#state.clockSkew;
  }

  #topics(): Topics {
    const { seen: _seen, ...state } = this.#state;
    return { ...state, connection: this.#connection };
  }

  #schedule(): void {
    if (this.#timer !== undefined) return;
    const wait = this.#lastFlush + RENDER_INTERVAL_MS - this.#now();
    if (wait <= 0) this.#flush();
    else this.#timer = setTimeout(() => this.#flush(), wait);
  }

  #flush(): void {
    clearTimeout(this.#timer);
    this.#timer = undefined;
    this.#lastFlush = this.#now();
    const before = this.#shown;
    this.#shown = this.#topics();
    for (const [topic, listeners] of this.#listeners) {
      if (before[topic] === this.#shown[topic]) continue;
      for (const listener of listeners) listener();
    }
  }
}
