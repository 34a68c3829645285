import { createContext, useCallback, useContext, useEffect, useRef, useSyncExternalStore } from "react";
import { onBeat, steadyNow } from "./beat";

/** Tells now in the gateway's time (ms), which its timestamps are compared with. */
interface Clock {
  gatewayNow(): number;
}

const ClockContext = createContext<Clock>({ gatewayNow: steadyNow });

export const ClockProvider = ClockContext.Provider;

/** Now in the gateway's time (ms), renewed every `intervalMs`; for ages and elapsed times. */
export function useGatewayNow(intervalMs = 1000): number {
  return useAtTime((now) => now, intervalMs);
}

/** What is read off the gateway's time (ms): looked at every `intervalMs`, re-rendered only where it is another. */
export function useAtTime<Value extends string | number | boolean>(
  read: (now: number) => Value,
  intervalMs = 1000,
): Value {
  const clock = useContext(ClockContext);
  const renders = useRef(0);
  const value = read(clock.gatewayNow());
  const shown = useRef({ read, value });
  useEffect(() => {
    shown.current = { read, value };
  });
  const subscribe = useCallback(
    (renderAnew: () => void) =>
      onBeat(intervalMs, () => {
        if (shown.current.read(clock.gatewayNow()) === shown.current.value) return;
        renders.current += 1;
        renderAnew();
      }),
    [clock, intervalMs],
  );
  // As a store of its own, and not as a state, it is rendered at once: in the frame of the beat.
  useSyncExternalStore(subscribe, () => renders.current);
  return value;
}
