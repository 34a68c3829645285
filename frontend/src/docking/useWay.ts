import { useEffect } from "react";
import { statusesOf } from "../api/stages";
import { useFleet } from "../fleet/context";
import { useLive, useServices, useTopicPart } from "../store/context";
import type { StageVisit } from "../store/stages";

const NONE: readonly StageVisit[] = [];

/** The stages that a goal was in. What it was in before this page was opened is read from its history. */
export function useWay(goalId: string): readonly StageVisit[] {
  const { http } = useFleet();
  const { store } = useServices();
  const live = useLive();
  const visits = useTopicPart("stages", (stages) => stages.get(goalId) ?? NONE);
  const incomplete = live && visits.some(({ since }) => since === null);

  useEffect(() => {
    if (!incomplete) return;
    let wanted = true;
    statusesOf(http, goalId)
      .then((statuses) => wanted && store.setWay(goalId, statuses))
      // The stages are shown all the same, without their times.
      .catch(() => {});
    return () => {
      wanted = false;
    };
  }, [http, store, goalId, incomplete]);

  return visits;
}
