/*
 * What changes by itself does so on common beats: a frame costs much more than what is drawn in it, so that what is due at
 * about the same time is shown in one. The browser draws no frames while nobody can see the page: then nothing beats.
 */

/** The shortest one: fifteen a second, smooth enough for what moves, at a quarter of what every frame would cost (ms). */
export const BEAT_MS = 200 / 3;

/**
 * Calls back once: in the frame after the next moment (of this computer's clock) that the interval divides, and not before
 * the page can be seen. Returns what takes that back.
 */
export function atBeat(intervalMs: number, callback: () => void): () => void {
  let frame: number | undefined;
  const timer = setTimeout(() => {
    frame = requestAnimationFrame(callback);
  }, untilBeat(intervalMs));
  return () => {
    clearTimeout(timer);
    if (frame !== undefined) cancelAnimationFrame(frame);
  };
}

interface Ticker {
  listeners: Set<() => void>;
  stop: () => void;
}

/** By interval: one timer for all who listen, so that a hundred ages are rendered together. */
const tickers = new Map<number, Ticker>();

/** Calls `listener` on every beat until the returned function is called. */
export function onBeat(intervalMs: number, listener: () => void): () => void {
  const ticker = tickers.get(intervalMs) ?? startTicker(intervalMs);
  ticker.listeners.add(listener);
  return () => {
    ticker.listeners.delete(listener);
    if (ticker.listeners.size > 0) return;
    ticker.stop();
    tickers.delete(intervalMs);
  };
}

function startTicker(intervalMs: number): Ticker {
  const ticker: Ticker = { listeners: new Set(), stop: atBeat(intervalMs, beat) };
  tickers.set(intervalMs, ticker);
  return ticker;

  function beat() {
    ticker.stop = atBeat(intervalMs, beat);
    for (const listener of ticker.listeners) listener();
  }
}

/** In whole milliseconds, as the clock has them. */
function untilBeat(intervalMs: number): number {
  const now = Date.now();
  return Math.ceil((Math.floor(now / intervalMs) + 1) * intervalMs) - now;
}
