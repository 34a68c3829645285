import { useFleet, useFleetLive } from "../../../fleet/context";
import { useAnswer } from "../../../ui/requests";
import { ENDED, useOpenMissions } from "../openMissions";
import { listEndedSince, type Mission } from "../requests";

/** The missions that have not ended, and those that have since a time (ms). `useFreshMissions` keeps them as they are. */
export function useMissionsSince(since: number) {
  const { http } = useFleet();
  const open = useOpenMissions();
  const ended = useAnswer({
    queryKey: [...ENDED, "since", since],
    queryFn: () => listEndedSince(http, new Date(since).toISOString()),
    enabled: useFleetLive(),
  });
  const missions: Mission[] | undefined =
    open.data === undefined || ended.data === undefined ? undefined : [...open.data, ...ended.data];
  return {
    missions,
    error: open.error ?? ended.error,
    refetch: () => {
      void open.refetch();
      void ended.refetch();
    },
  };
}
