import type { ConnectionInput, GatewayEvent, LiveGoal } from "@dock-gateway/client";
import { atBeat, BEAT_MS } from "../clock/beat";
import { type Connection, initialConnection, nextConnection } from "../stream/connection";
import { mergeGoals } from "./goals";
import { MAX_SEEN, type StreamState } from "./state";

/**
 * The state after an event: as `apply` says, unless it has come before, and as each stream takes up a heartbeat. Pure.
 *
 * @param now This computer's time when the event came (ms).
 */
export function takeUp<State extends StreamState>(
  state: State,
  event: GatewayEvent,
  now: number,
  apply: (state: State, event: GatewayEvent, now: number) => State,
): State {
  // The smallest difference is the one with the least delay on the way.
  if (event.type === "heartbeat")
    return { ...state, clockSkew: Math.min(state.clockSkew, now - Date.parse(event.time)) };
  // The id of a snapshot is that of the last event before it. The present state has none.
  if (!("id" in event) || event.id === null || event.type === "snapshot") return apply(state, event, now);
  if (state.seen.has(event.id)) return state;
  return apply({ ...state, seen: remember(state.seen, event.id) }, event, now);
}

/** Adds the id of an event that was seen; the oldest are forgotten. */
function remember(seen: ReadonlySet<string>, id: string): ReadonlySet<string> {
  const next = new Set(seen).add(id);
  for (const oldest of next) {
    if (next.size <= MAX_SEEN) break;
    next.delete(oldest);
  }
  return next;
}

/** Holds what is known from a stream, and shows it at most five times a second; a change of the connection at once. */
export abstract class StreamStore<State extends StreamState, Topics extends object> {
  protected state: State;
  #connection: Connection;
  protected readonly shown: Shown<Topics>;
  readonly #now: () => number;
  readonly #reduce: (state: State, event: GatewayEvent, now: number) => State;

  constructor(
    initial: State,
    reduce: (state: State, event: GatewayEvent, now: number) => State,
    topicsOf: (state: State, connection: Connection) => Topics,
    now: () => number,
  ) {
    this.state = initial;
    this.#reduce = reduce;
    this.#now = now;
    this.#connection = initialConnection(now());
    this.shown = new Shown(() => topicsOf(this.state, this.#connection), now);
  }

  /** Takes up an event; whether it changes anything. */
  protected take(event: GatewayEvent): boolean {
    const before = this.state;
    this.state = this.#reduce(before, event, this.#now());
    return this.state !== before;
  }

  readonly onConnection = (input: ConnectionInput): void => {
    const next = nextConnection(this.#connection, input, this.#now());
    if (next === this.#connection) return;
    this.#connection = next;
    this.shown.flush();
  };

  /** Takes up goals from an answer over HTTP: at once, as people wait for it. */
  addGoals(goals: readonly LiveGoal[]): void {
    this.state = mergeGoals(this.state, goals);
    this.shown.flush();
  }

  get<T extends keyof Topics>(topic: T): Topics[T] {
    return this.shown.get(topic);
  }

  subscribe(topic: keyof Topics, listener: () => void): () => void {
    return this.shown.subscribe(topic, listener);
  }

  /** Now, in the gateway's time (ms): what its timestamps are compared with. */
  gatewayNow(): number {
    return this.#now() - this.state.clockSkew;
  }
}

/** Subscribers are called at most this often, whatever the message rate. */
export const RENDER_INTERVAL_MS = 200;

/**
 * What is shown of a state that changes often: all of its topics as of one moment, renewed at most five times a second,
 * and not at all while the page is hidden. Each topic has subscribers of its own, called when it is another object.
 */
export class Shown<Topics extends object> {
  #shown: Topics;
  #lastFlush = Number.NEGATIVE_INFINITY;
  /** Takes back what is to be shown soon. */
  #cancel: (() => void) | undefined;
  readonly #listeners = new Map<keyof Topics, Set<() => void>>();
  readonly #read: () => Topics;
  readonly #now: () => number;

  constructor(read: () => Topics, now: () => number) {
    this.#read = read;
    this.#now = now;
    this.#shown = read();
  }

  /** What is shown of a topic; the same object until it changes. */
  get<Topic extends keyof Topics>(topic: Topic): Topics[Topic] {
    return this.#shown[topic];
  }

  subscribe(topic: keyof Topics, listener: () => void): () => void {
    const listeners = this.#listeners.get(topic) ?? new Set();
    this.#listeners.set(topic, listeners.add(listener));
    return () => listeners.delete(listener);
  }

  /** Something has changed: show it soon, or as soon as the page can be seen again. */
  schedule(): void {
    if (this.#cancel !== undefined) return;
    const rested = this.#now() - this.#lastFlush >= RENDER_INTERVAL_MS;
    this.#cancel = atBeat(rested ? BEAT_MS : RENDER_INTERVAL_MS, () => this.flush());
  }

  /** Show it now. */
  flush(): void {
    this.#cancel?.();
    this.#cancel = undefined;
    this.#lastFlush = this.#now();
    const before = this.#shown;
    this.#shown = this.#read();
    for (const [topic, listeners] of this.#listeners) {
      if (before[topic] === this.#shown[topic]) continue;
      for (const listener of listeners) listener();
    }
  }
}
