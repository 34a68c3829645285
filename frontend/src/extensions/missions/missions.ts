import { useQueryClient } from "@tanstack/react-query";
import { refusedFields } from "../../actions/DraftFields";
import { useFleet, useFleetLive } from "../../fleet/context";
import { useAnswer, useCommand, usePages } from "../../ui/requests";
import type { Draft } from "./draft";
import { take } from "./freshMissions";
import { ENDED, KEY, ONE } from "./openMissions";
import {
  changeMission,
  createMission,
  getMission,
  listEnded,
  type Mission,
  moveMission,
  type Place,
  replaceMission,
  type Verb,
} from "./requests";
import { withRefused } from "./wrong";

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

/** Moves a mission in its queue; where the others are then comes with the events. */
export function useMove() {
  const { http } = useFleet();
  const client = useQueryClient();
  return useCommand(async ({ id, place }: { id: string; place: Place }) => {
    try {
      take(client, await moveMission(http, id, place));
    } finally {
      void client.invalidateQueries({ queryKey: KEY });
    }
  });
}

/**
 * Queues a mission, or replaces one that has not begun.
 *
 * @param onChange Gets what the gateway has refused of the draft.
 */
export function useSaveMission(
  { robot, group }: Pick<Draft, "robot" | "group">,
  onChange: (change: (before: Draft) => Draft) => void,
) {
  const { http } = useFleet();
  const client = useQueryClient();
  return useCommand(async ({ body, base }: { body: string; base: Mission | null }) => {
    try {
      if (base === null) await createMission(http, group === null ? robot : null, body);
      else take(client, await replaceMission(http, base, body));
    } catch (error) {
      const refused = refusedFields(error);
      if (refused.length > 0) onChange((before) => withRefused(before, refused));
      void client.invalidateQueries({ queryKey: KEY });
      throw error;
    }
  });
}
