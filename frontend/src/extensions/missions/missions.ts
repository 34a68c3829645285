import { useQueryClient } from "@tanstack/react-query";
import { useFleet, useFleetLive } from "../../fleet/context";
import { useAnswer, useCommand, usePages } from "../../ui/requests";
import { ENDED, KEY, ONE } from "./openMissions";
import { changeMission, getMission, listEnded, type Verb } from "./requests";

/** The ended ones, newest first. */
export function useEndedMissions() {
  const { http } = useFleet();
  return usePages({
    queryKey: [...ENDED],
    queryFn: (cursor: string | null) => listEnded(http, cursor),
    enabled: useFleetLive(),
  });
}

/** One mission. @param id Null for none. */
export function useMission(id: string | null) {
  const { http } = useFleet();
  const live = useFleetLive();
  return useAnswer({
    queryKey: [...ONE, id],
    queryFn: () => getMission(http, id ?? ""),
    enabled: live && id !== null,
    staleTime: Number.POSITIVE_INFINITY,
  });
}

/** Changes a mission; what it is then comes with the events. */
export function useMissionCommand() {
  const { http } = useFleet();
  const client = useQueryClient();
  return useCommand(({ id, verb }: { id: string; verb: Verb }) =>
    changeMission(http, id, verb).finally(() => void client.invalidateQueries({ queryKey: KEY })),
  );
}
