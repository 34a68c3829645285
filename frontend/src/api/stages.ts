import { deadline, type Http, settle } from "./http";
import type { components } from "./schema.gen";

type Schemas = components["schemas"];
type StatusEvent = Extract<Schemas["GoalHistory"]["events"][number], { type: "status" }>;

/** A goal has a status event for each stage; more than this many pages of them is a server that runs wild. */
const MAX_PAGES = 5;

/** The statuses of a goal with its stages, oldest first. */
export interface Statuses {
  events: StatusEvent[];
  /** False where the history does not reach back to the goal's beginning. */
  complete: boolean;
}

/** Every status that a goal was in, as far as the history goes back. */
export async function statusesOf(http: Http, goalId: string): Promise<Statuses> {
  const events: StatusEvent[] = [];
  let [complete, after] = [true, null as string | null];
  for (let page = 0; page < MAX_PAGES; page += 1) {
    const query = { type: ["status" as const], limit: 1000, ...(after === null ? {} : { after }) };
    const answer: Schemas["GoalHistory"] = await settle(
      http.GET("/goals/{goal_id}/history", {
        params: { path: { goal_id: goalId }, query },
        signal: deadline(),
      }),
    );
    for (const event of answer.events) if (event.type === "status") events.push(event);
    complete &&= answer.complete;
    after = answer.next_after;
    if (after === null) break;
  }
  return { events, complete };
}
