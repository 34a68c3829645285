import { isTerminal, type LiveGoal } from "@dock-gateway/client";
import { Button } from "@mantine/core";
import { useFleet } from "../../fleet/context";
import { fixed } from "../../ui/numbers";
import { ReasonButton } from "../../ui/ReasonButton";
import { useAnswer } from "../../ui/requests";
import { GoalPicture } from "./GoalPicture";
import { recordingOf, recordingUrl } from "./requests";

/** How often it is asked whether a recording is complete (ms). */
export const AGAIN_MS = 1000;

/** Whether a goal has a recording; asked again until that is complete. */
export function useRecording(goal: LiveGoal) {
  const { http } = useFleet();
  return useAnswer({
    queryKey: ["recording", goal.goal_id, goal.finished_at],
    queryFn: () => recordingOf(http, goal.goal_id),
    refetchInterval: ({ state }) =>
      isTerminal(goal.status) && state.data?.state === "running" ? AGAIN_MS : false,
  });
}

/** What the robot's camera saw last, of a goal that has a recording. */
export function RecordedPicture({ goal }: { goal: LiveGoal }) {
  const { data } = useRecording(goal);
  return data?.picture === true ? <GoalPicture goalId={goal.goal_id} /> : null;
}

/** Downloads what was heard of the robot while a goal ran; without a recording it says why there is none. */
export function RecordingButton({ goal }: { goal: LiveGoal }) {
  const { data } = useRecording(goal);
  if (data == null) return null;
  if (data.size_bytes === null) {
    return (
      <ReasonButton variant="default" size="compact-sm" reason={data.reason ?? "There is none."}>
        Recording
      </ReasonButton>
    );
  }
  return (
    <Button component="a" href={recordingUrl(goal.goal_id)} download variant="default" size="compact-sm">
      Recording, {sizeText(data.size_bytes)}
    </Button>
  );
}

/** `12 kB`, `3.4 MB`. */
export function sizeText(bytes: number): string {
  return bytes < 1_000_000 ? `${Math.ceil(bytes / 1000)} kB` : `${fixed(bytes / 1_000_000, 1)} MB`;
}
