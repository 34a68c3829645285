import type { GatewayEvent } from "@dock-gateway/client";
import { type QueryClient, useQueryClient } from "@tanstack/react-query";
import { useEffect } from "react";
import { useFleet, useFleetLive } from "../../fleet/context";
import { openStream, streamUrl } from "../../stream/stream";
import { useAnswer, useCommand, usePages } from "../../ui/requests";
import { hasEnded, withMission } from "./queue";
import { changeMission, getMission, listEnded, listOpen, type Mission, type Verb } from "./requests";

const KEY = ["missions"] as const;
const OPEN = [...KEY, "open"] as const;
const ENDED = [...KEY, "ended"] as const;
const ONE = [...KEY, "one"] as const;

/** The missions that have not ended, renewed by `useFreshMissions`. @param robot Only those of this robot; of all for null. */
export function useOpenMissions(robot: string | null = null) {
  const { http } = useFleet();
  return useAnswer({
    queryKey: [...OPEN, robot],
    queryFn: () => listOpen(http, robot),
    enabled: useFleetLive(),
    staleTime: Number.POSITIVE_INFINITY,
  });
}

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

/** Keeps missions as the gateway says that they are, by its events. */
export function useFreshMissions(): void {
  const client = useQueryClient();
  useEffect(() => {
    const onEvent = (event: GatewayEvent) => event.type === "mission" && take(client, event.mission);
    // What has changed while there was no connection has no event.
    const onConnection = ({ kind }: { kind: string }) =>
      kind === "snapshot" && void client.invalidateQueries({ queryKey: KEY });
    return openStream(streamUrl(window.location, { include: "mission", feedback: "false" }), {
      onEvent,
      onConnection,
    });
  }, [client]);
}

/** Takes up what an event says of a mission. */
export function take(client: QueryClient, mission: Mission): void {
  for (const [key, known] of client.getQueriesData<Mission[]>({ queryKey: OPEN })) {
    const robot = key[OPEN.length];
    if (robot !== null && robot !== mission.robot) continue;
    if (known !== undefined) client.setQueryData(key, withMission(known, mission));
    // What is being read may be from before the event.
    if (client.isFetching({ queryKey: key, exact: true }))
      void client.invalidateQueries({ queryKey: key, exact: true });
  }
  client.setQueryData<Mission>([...ONE, mission.mission_id], (known) => known && mission);
  if (hasEnded(mission)) void client.invalidateQueries({ queryKey: ENDED });
}

/** Changes a mission; what it is then comes with the events. */
export function useMissionCommand() {
  const { http } = useFleet();
  const client = useQueryClient();
  return useCommand(({ id, verb }: { id: string; verb: Verb }) =>
    changeMission(http, id, verb).finally(() => void client.invalidateQueries({ queryKey: KEY })),
  );
}
