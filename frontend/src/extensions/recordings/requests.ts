import { type components, deadline, type Http, settle } from "@dock-gateway/client";
import { apiPath } from "../../api/site";

export type GoalReplay = components["schemas"]["GoalReplay"];
export type GoalRecording = components["schemas"]["GoalRecording"];

const one = (goalId: string) => ({ params: { path: { goal_id: goalId } }, signal: deadline() });

/** Whether there is a recording of a goal, or why there is none; null where nobody can tell. */
export async function recordingOf(http: Http, goalId: string): Promise<GoalRecording | null> {
  return (await settle(http.GET("/goals/{goal_id}", one(goalId)))).recording ?? null;
}

/** What the replay shows of a recording. */
export function replayOf(http: Http, goalId: string): Promise<GoalReplay> {
  return settle(http.GET("/goals/{goal_id}/replay", one(goalId)));
}

/** Where the last picture of the robot's camera in the recording of a goal is. */
export function thumbnailUrl(goalId: string): string {
  return apiPath(`/goals/${encodeURIComponent(goalId)}/thumbnail`);
}

/** Where the recording of a goal is downloaded. */
export function recordingUrl(goalId: string): string {
  return apiPath(`/goals/${encodeURIComponent(goalId)}/recording.mcap`);
}
