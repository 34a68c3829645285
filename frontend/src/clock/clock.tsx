import { createContext, useCallback, useContext, useEffect, useRef, useSyncExternalStore } from "react";
import { onBeat, steadyNow } from "./beat";
import { isSame } from "./same";

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

/** What `read` makes of the gateway's time (ms). It is read every `intervalMs`, and re-rendered if it has changed. */
export function useAtTime<Value>(read: (now: number) => Value, intervalMs = 1000): Value {
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
        if (isSame(shown.current.read(clock.gatewayNow()), shown.current.value)) return;
        renders.current += 1;
        renderAnew();
      }),
    [clock, intervalMs],
  );
  // As a store of its own, and not as a state, it is rendered at once: in the frame of the beat.
  useSyncExternalStore(subscribe, () => renders.current);
  return value;
}
