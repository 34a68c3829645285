import type { LiveGoal } from "@dock-gateway/client";
import { useFleet } from "../../fleet/context";
import { useAnswer } from "../../ui/requests";
import { useRecording } from "./RecordingButton";
import { replayOf } from "./requests";

/** What the replay shows of the recording of a goal; nothing while it is not known, and without a recording. */
export function useReplay(goal: LiveGoal) {
  const { http } = useFleet();
  const size = useRecording(goal).data?.size_bytes ?? null;
  return useAnswer({
    queryKey: ["replay", goal.goal_id, size],
    queryFn: () => replayOf(http, goal.goal_id),
    enabled: size !== null,
    staleTime: Number.POSITIVE_INFINITY,
  });
}
