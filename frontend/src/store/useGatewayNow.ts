import { useEffect, useState } from "react";
import { useServices } from "./context";

/** Now in the gateway's time (ms), renewed every `intervalMs`; for ages and elapsed times. */
export function useGatewayNow(intervalMs = 1000): number {
  const { store } = useServices();
  const [now, setNow] = useState(() => store.gatewayNow());
  useEffect(() => {
    const timer = setInterval(() => setNow(store.gatewayNow()), intervalMs);
    return () => clearInterval(timer);
  }, [store, intervalMs]);
  return now;
}
