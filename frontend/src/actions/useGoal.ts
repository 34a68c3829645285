import { useEffect, useState, useSyncExternalStore } from "react";
import type { AnyGoal } from "../api/types";
import { useFleetTopic } from "../fleet/context";
import { FleetStore } from "../fleet/store";
import { openStream, streamUrl } from "../stream/stream";

export interface Followed {
  goal: AnyGoal | null;
  /** When its latest feedback messages came (ms), oldest first. */
  arrivals: readonly number[];
}

/** A goal with its feedback as it comes: five times a second at most, where all goals have it more rarely. */
export function useGoal(goalId: string | null): Followed {
  const [store, setStore] = useState<FleetStore | null>(null);
  useEffect(() => {
    if (goalId === null) return;
    const own = new FleetStore();
    const close = openStream(streamUrl(window.location, { goal_id: goalId, max_rate: "10" }), own);
    setStore(own);
    return () => {
      close();
      setStore(null);
    };
  }, [goalId]);

  const goals = useSyncExternalStore(
    (listener) => store?.subscribe("goals", listener) ?? (() => {}),
    () => store?.get("goals"),
  );
  const fleet = useFleetTopic("goals");
  if (goalId === null) return { goal: null, arrivals: [] };
  return {
    goal: (goals?.get(goalId) ?? fleet.get(goalId) ?? null) as AnyGoal | null,
    arrivals: store?.get("arrivals").get(goalId) ?? [],
  };
}
