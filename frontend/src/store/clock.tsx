import { createContext, useContext, useEffect, useState } from "react";

/** Tells now in the gateway's time (ms), which its timestamps are compared with. */
export interface Clock {
  gatewayNow(): number;
}

const ClockContext = createContext<Clock>({ gatewayNow: Date.now });

export const ClockProvider = ClockContext.Provider;

/** Now in the gateway's time (ms), renewed every `intervalMs`; for ages and elapsed times. */
export function useGatewayNow(intervalMs = 1000): number {
  const clock = useContext(ClockContext);
  const [now, setNow] = useState(() => clock.gatewayNow());
  useEffect(() => {
    const timer = setInterval(() => setNow(clock.gatewayNow()), intervalMs);
    return () => clearInterval(timer);
  }, [clock, intervalMs]);
  return now;
}
