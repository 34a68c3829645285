import type { LiveGoal } from "@dock-gateway/client";
import { useAnswer } from "../ui/requests";
import { useWatched } from "./useGoalWatch";

/** The stored poses of a goal that has ended, oldest first; asked for once. */
export function usePoses(goal: LiveGoal) {
  const { api } = useWatched();
  return useAnswer({
    queryKey: ["poses", goal.goal_id, goal.finished_at],
    queryFn: () => api.poses(goal.goal_id),
    staleTime: Number.POSITIVE_INFINITY,
  });
}
