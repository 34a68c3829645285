import { useAtTime } from "../clock/clock";
import { useFleetLive } from "../fleet/context";
import { durationWords, type Lifetime } from "./duration";

/** How long a goal took, or has been running for. */
export function GoalDuration({ goal }: { goal: Lifetime }) {
  const words = useAtTime((now) => durationWords(goal, now));
  const live = useFleetLive();
  return live || goal.finished_at !== null ? words : "not live";
}
