import { focusManager, QueryClient } from "@tanstack/react-query";
import { session } from "./session";

/**
 * Asks the gateway and gives its answer, or its failure, at once. `networkMode: "online"`, the default, would hold back
 * what is asked while the browser thinks it is offline, and send it later: for a robot's commands that is dangerous, and
 * a gateway on this computer needs no network.
 */
export function createQueryClient(): QueryClient {
  return new QueryClient({
    defaultOptions: {
      queries: { networkMode: "always", retry: false, refetchOnWindowFocus: false },
      mutations: { networkMode: "always", retry: false },
    },
  });
}

/**
 * Nothing is polled while the page is hidden, or without a login: each of these requests would
 * be refused. Queries go on with their `refetchInterval` afterwards.
 */
export function pauseWhileUnseen(): void {
  focusManager.setEventListener((setFocused) => {
    const look = () => setFocused(document.visibilityState !== "hidden" && !session.loggedOut);
    const forget = session.subscribe(look);
    document.addEventListener("visibilitychange", look);
    look();
    return () => {
      forget();
      document.removeEventListener("visibilitychange", look);
    };
  });
}
