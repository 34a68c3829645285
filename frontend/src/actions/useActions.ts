import { useQuery } from "@tanstack/react-query";
import { useMemo } from "react";
import { type ActionSchemas, type ActionsApi, createActionsApi } from "../api/actions";
import { type CommandError, toCommandError } from "../api/errors";
import type { ActionInfo } from "../api/types";
import { useFleet } from "../fleet/context";

/** How often the graph is looked at. */
const LOOK_EVERY_MS = 2000;

export function useActionsApi(): ActionsApi {
  const { http } = useFleet();
  return useMemo(() => createActionsApi(http), [http]);
}

/** Every action on the graph, by name; looked up again while the page is seen. */
export function useActions() {
  const api = useActionsApi();
  return useQuery<ActionInfo[], CommandError>({
    queryKey: ["actions"],
    queryFn: () => api.list().then(byName).catch(fail),
    refetchInterval: LOOK_EVERY_MS,
  });
}

/** The messages of an action type. */
export function useSchemas(type: string) {
  const api = useActionsApi();
  return useQuery<ActionSchemas, CommandError>({
    queryKey: ["interface", type],
    queryFn: () => api.schemas(type).catch(fail),
    staleTime: Number.POSITIVE_INFINITY,
  });
}

function byName(actions: ActionInfo[]): ActionInfo[] {
  return actions.sort((a, b) => a.action_name.localeCompare(b.action_name));
}

function fail(error: unknown): never {
  throw toCommandError(error);
}
