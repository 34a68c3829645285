import { deadline, type Http, settle } from "@dock-gateway/client";
import { useFleet, useFleetLive } from "../../fleet/context";
import { lazyPart } from "../../ui/lazyPart";
import { useAnswer } from "../../ui/requests";
import type { MissionList, MissionStatus } from "./requests";

/** Under which the page keeps missions: all, those that have not ended, the ended ones, one by its id. */
export const KEY = ["missions"] as const;
export const OPEN = [...KEY, "open"] as const;
export const ENDED = [...KEY, "ended"] as const;
export const ONE = [...KEY, "one"] as const;

const OPEN_STATES: MissionStatus[] = ["queued", "running", "held", "canceling"];
/** As many as have not ended at most. */
const MOST_OPEN = 500;

/**
 * The missions that have not ended. `useFreshMissions` keeps them as they are.
 *
 * @param robot Only those of this robot; of all for null.
 * @param everyMs How often they are asked for, where nothing keeps them.
 */
export function useOpenMissions(robot: string | null = null, everyMs: number | false = false) {
  const { http } = useFleet();
  return useAnswer({
    queryKey: [...OPEN, robot],
    queryFn: () => listOpen(http, robot),
    select: ({ missions }) => missions,
    enabled: useFleetLive(),
    staleTime: Number.POSITIVE_INFINITY,
    refetchInterval: everyMs,
  });
}

/** Those that have not ended. @param robot Only those of this robot; of all for null. */
function listOpen(http: Http, robot: string | null): Promise<MissionList> {
  const query = { status: OPEN_STATES, limit: MOST_OPEN, ...(robot !== null && { robot }) };
  return settle(http.GET("/missions", { params: { query }, signal: deadline() }));
}

const RobotQueue = lazyPart(() => import("./RobotQueue"));

/** How often a robot's page looks, in ms: a stream of its own would be one more connection of every page. */
const LOOK_MS = 5000;

/** The missions of a robot that have not ended; nothing, also to load, where there is none. */
export function RobotMission({ robot }: { robot: string }) {
  const { data: missions = [] } = useOpenMissions(robot, LOOK_MS);
  return missions.length > 0 && <RobotQueue missions={missions} />;
}
