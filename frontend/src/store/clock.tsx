import { createContext, useContext, useEffect, useReducer, useRef } from "react";

/** Tells now in the gateway's time (ms), which its timestamps are compared with. */
export interface Clock {
  gatewayNow(): number;
}

const ClockContext = createContext<Clock>({ gatewayNow: Date.now });

export const ClockProvider = ClockContext.Provider;

/** Now in the gateway's time (ms), renewed every `intervalMs`; for ages and elapsed times. */
export function useGatewayNow(intervalMs = 1000): number {
  return useAtTime((now) => now, intervalMs);
}

/** What is read off the gateway's time (ms): looked at every `intervalMs`, rendered anew only where it is another. */
export function useAtTime<Value extends string | number | boolean>(
  read: (now: number) => Value,
  intervalMs = 1000,
): Value {
  const clock = useContext(ClockContext);
  const [, renderAnew] = useReducer((count: number) => count + 1, 0);
  const value = read(clock.gatewayNow());
  const shown = useRef({ read, value });
  useEffect(() => {
    shown.current = { read, value };
  });
  useEffect(
    () =>
      onTick(intervalMs, () => {
        if (shown.current.read(clock.gatewayNow()) !== shown.current.value) renderAnew();
      }),
    [clock, intervalMs],
  );
  return value;
}

interface Ticker {
  timer: ReturnType<typeof setInterval>;
  listeners: Set<() => void>;
}

/** By interval: one timer for all who listen, so that a hundred ages are rendered together. */
const tickers = new Map<number, Ticker>();

function onTick(intervalMs: number, listener: () => void): () => void {
  const ticker = tickers.get(intervalMs) ?? startTicker(intervalMs);
  ticker.listeners.add(listener);
  return () => {
    ticker.listeners.delete(listener);
    if (ticker.listeners.size > 0) return;
    clearInterval(ticker.timer);
    tickers.delete(intervalMs);
  };
}

function startTicker(intervalMs: number): Ticker {
  const listeners = new Set<() => void>();
  const timer = setInterval(() => {
    for (const listener of listeners) listener();
  }, intervalMs);
  const ticker = { timer, listeners };
  tickers.set(intervalMs, ticker);
  return ticker;
}
