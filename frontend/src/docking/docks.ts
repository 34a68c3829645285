import type { ActionServer, DockList } from "@dock-gateway/client";
import { useQuery } from "@tanstack/react-query";
import { useLive, useServices } from "../store/context";

const REFETCH_MS = 30_000;

/** The docks that the docking server of a robot knows by name; undefined before it has answered, or where it knows none. */
export function useDockList(server: ActionServer | null): DockList | undefined {
  const { gateway, robot } = useServices();
  const live = useLive();
  const { data } = useQuery({
    queryKey: ["docks", robot, server?.action_name],
    queryFn: gateway.docks,
    refetchInterval: REFETCH_MS,
    enabled: live && server?.available === true,
  });
  return data;
}
