import type { GatewayEvent } from "@dock-gateway/client";
import { type QueryClient, type QueryKey, useQueryClient } from "@tanstack/react-query";
import { useEffect } from "react";
import { openStream, streamUrl } from "../../stream/stream";
import { ENDED, KEY, ONE, OPEN } from "./openMissions";
import { hasEnded, withMission } from "./queue";
import type { Mission, MissionList } from "./requests";

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
    readAgain(client, key);
  }
  const one = [...ONE, mission.mission_id];
  client.setQueryData<Mission>(one, (known) => known && mission);
  readAgain(client, one);
  if (hasEnded(mission)) void client.invalidateQueries({ queryKey: ENDED });
}

/** What is being read may be from before an event. To invalidate it would not ask again while nothing is known. */
function readAgain(client: QueryClient, queryKey: QueryKey): void {
  const query = { queryKey, exact: true };
  if (client.isFetching(query) > 0)
    void client.cancelQueries(query).then(() => client.invalidateQueries(query));
}
