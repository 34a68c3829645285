import type { AnyGoal } from "../api/types";
import { useFleetLive } from "../fleet/context";
import { useAtTime } from "../store/clock";
import { formatDuration } from "../ui/time";

/** How long a goal took, or has been running for. */
export function GoalDuration({ goal }: { goal: Pick<AnyGoal, "created_at" | "finished_at"> }) {
  const start = Date.parse(goal.created_at);
  if (goal.finished_at === null) return <Elapsed start={start} />;
  return formatDuration(Date.parse(goal.finished_at) - start);
}

function Elapsed({ start }: { start: number }) {
  const words = useAtTime((now) => formatDuration(now - start));
  const live = useFleetLive();
  return live ? words : "not live";
}
