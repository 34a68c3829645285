import { useEffect } from "react";
import { statusesOf } from "../api/stages";
import type { Goal } from "../api/types";
import { useFleet } from "../fleet/context";
import { useLive, useServices, useTopic } from "../store/context";
import type { StageVisit } from "../store/stages";

const NONE: readonly StageVisit[] = [];

/** The stages that a goal was in. What it was in before this page was opened is read from its history. */
export function useWay(goal: Goal): readonly StageVisit[] {
  const { http } = useFleet();
  const { store } = useServices();
  const live = useLive();
  const visits = useTopic("stages").get(goal.goal_id) ?? NONE;
  const incomplete = live && visits.some(({ since }) => since === null);

  useEffect(() => {
    if (!incomplete) return;
    let wanted = true;
    statusesOf(http, goal.goal_id)
      .then((statuses) => wanted && store.setWay(goal.goal_id, statuses))
      // The stages are shown all the same, without their times.
      .catch(() => {});
    return () => {
      wanted = false;
    };
  }, [http, store, goal.goal_id, incomplete]);

  return visits;
}
