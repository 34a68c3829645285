import { QueryClient } from "@tanstack/react-query";

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
