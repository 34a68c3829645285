import { atBeat, BEAT_MS } from "../clock/beat";

/** Subscribers are told at most this often, whatever the message rate. */
export const RENDER_INTERVAL_MS = 200;

/**
 * What is shown of a state that changes often: all of its topics as of one moment, renewed at most five times a second,
 * and not at all while nobody can see the page. Each topic has subscribers of its own, told when it is another object.
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
