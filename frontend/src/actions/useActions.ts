import { useMemo } from "react";
import { createActionsApi } from "../api/actions";
import type { ActionInfo } from "../api/types";
import { useFleet } from "../fleet/context";
import { useAnswer } from "../ui/requests";

/** How often the graph is looked at. */
const LOOK_EVERY_MS = 2000;

export function useActionsApi() {
  const { http } = useFleet();
  return useMemo(() => createActionsApi(http), [http]);
}

/** Every action on the graph, by name; looked up again while the page is seen. */
export function useActions() {
  const api = useActionsApi();
  return useAnswer({
    queryKey: ["actions"],
    queryFn: () => api.list().then(byName),
    refetchInterval: LOOK_EVERY_MS,
  });
}

/** The messages of an action type. */
export function useSchemas(type: string) {
  const api = useActionsApi();
  return useAnswer({
    queryKey: ["interface", type],
    queryFn: () => api.schemas(type),
    staleTime: Number.POSITIVE_INFINITY,
  });
}

function byName(actions: ActionInfo[]): ActionInfo[] {
  return actions.sort((a, b) => a.action_name.localeCompare(b.action_name));
}
