import { deadline, type GatewayEvent, type Http, settle } from "@dock-gateway/client";
import { type QueryClient, useQueryClient } from "@tanstack/react-query";
import { useEffect } from "react";
import { useFleet, useFleetLive } from "../../fleet/context";
import { openStream, streamUrl } from "../../stream/stream";
import { lazyPart } from "../../ui/lazyPart";
import { useAnswer } from "../../ui/requests";
import type { Mission, MissionList, MissionStatus } from "./requests";

/** Under which the page keeps missions: all, those that have not ended, the ended ones, one by its id. */
export const KEY = ["missions"] as const;
const OPEN = [...KEY, "open"] as const;
export const ENDED = [...KEY, "ended"] as const;
export const ONE = [...KEY, "one"] as const;

const OPEN_STATES: MissionStatus[] = ["queued", "running", "held", "canceling"];
/** As many as have not ended at most. */
const MOST_OPEN = 500;

/** Whether no other state follows. */
export function hasEnded({ status }: Pick<Mission, "status">): boolean {
  return status === "succeeded" || status === "failed" || status === "canceled";
}

/** The missions that have not ended, after one has changed. */
export function withMission(missions: readonly Mission[], changed: Mission): Mission[] {
  const others = missions.filter(({ mission_id }) => mission_id !== changed.mission_id);
  return hasEnded(changed) ? others : [...others, changed];
}

/** The missions that have not ended, renewed by `useFreshMissions`. @param robot Only those of this robot; of all for null. */
export function useOpenMissions(robot: string | null = null) {
  const { http } = useFleet();
  return useAnswer({
    queryKey: [...OPEN, robot],
    queryFn: () => listOpen(http, robot),
    select: ({ missions }) => missions,
    enabled: useFleetLive(),
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
  for (const [key, known] of client.getQueriesData<MissionList>({ queryKey: OPEN })) {
    const robot = key[OPEN.length];
    if (robot !== null && robot !== mission.robot) continue;
    if (known !== undefined)
      client.setQueryData(key, { ...known, missions: withMission(known.missions, mission) });
    // What is being read may be from before the event.
    if (client.isFetching({ queryKey: key, exact: true }))
      void client.invalidateQueries({ queryKey: key, exact: true });
  }
  client.setQueryData<Mission>([...ONE, mission.mission_id], (known) => known && mission);
  if (hasEnded(mission)) void client.invalidateQueries({ queryKey: ENDED });
}

/** Those that have not ended. @param robot Only those of this robot; of all for null. */
function listOpen(http: Http, robot: string | null): Promise<MissionList> {
  const query = { status: OPEN_STATES, limit: MOST_OPEN, ...(robot !== null && { robot }) };
  return settle(http.GET("/missions", { params: { query }, signal: deadline() }));
}

const RobotQueue = lazyPart(() => import("./RobotQueue"));

/** The missions of a robot that have not ended; nothing, also to load, where there is none. */
export default function RobotMission({ robot }: { robot: string }) {
  useFreshMissions();
  const { data: missions = [] } = useOpenMissions(robot);
  return missions.length > 0 && <RobotQueue missions={missions} />;
}
