import { useSyncExternalStore } from "react";

/** What this browser keeps under a key; null where there is nothing, or storage is blocked. */
export function readKept(key: string): string | null {
  try {
    return localStorage.getItem(key);
  } catch {
    return null;
  }
}

/** Keeps a text in this browser, nothing for null. Returns whether it could be kept. */
export function keep(key: string, text: string | null): boolean {
  try {
    if (text === null) localStorage.removeItem(key);
    else localStorage.setItem(key, text);
    return true;
  } catch {
    return false;
  }
}

/** A value that this browser keeps, also for its other tabs. Where storage is blocked, it holds until the page is closed. */
export class Kept<T> {
  readonly #listeners = new Set<() => void>();
  #value: T | undefined;

  /**
   * @param key Of the storage.
   * @param read What a text means, whatever it is; null where nothing is kept.
   * @param write The text of a value.
   */
  constructor(
    private readonly key: string,
    private readonly read: (text: string | null) => T,
    private readonly write: (value: T) => string,
  ) {}

  get value(): T {
    this.#value ??= this.read(readKept(this.key));
    return this.#value;
  }

  set value(value: T) {
    this.#value = value;
    keep(this.key, this.write(value));
    for (const listener of this.#listeners) listener();
  }

  readonly subscribe = (listener: () => void): (() => void) => {
    const hear = ({ key }: StorageEvent) => {
      if (key !== this.key && key !== null) return;
      this.#value = undefined;
      listener();
    };
    this.#listeners.add(listener);
    window.addEventListener("storage", hear);
    return () => {
      this.#listeners.delete(listener);
      window.removeEventListener("storage", hear);
    };
  };
}

/** The value, which re-renders when it changes. */
export function useKept<T>(kept: Kept<T>): T {
  return useSyncExternalStore(kept.subscribe, () => kept.value);
}
