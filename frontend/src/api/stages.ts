import { deadline, type Http, settle } from "./http";
import type { components } from "./schema.gen";

type Schemas = components["schemas"];
type StatusEvent = Extract<Schemas["GoalHistory"]["events"][number], { type: "status" }>;

/** A goal has a status event for each stage; more than this many pages of them is a server that runs wild. */
const MAX_PAGES = 5;

/** Every status that a goal was in, with its stage, oldest first. */
export async function statusesOf(http: Http, goalId: string): Promise<StatusEvent[]> {
  const events: StatusEvent[] = [];
  let after: string | null = null;
  for (let page = 0; page < MAX_PAGES; page += 1) {
    const query = { type: ["status" as const], limit: 1000, ...(after === null ? {} : { after }) };
    const answer: Schemas["GoalHistory"] = await settle(
      http.GET("/goals/{goal_id}/history", {
        params: { path: { goal_id: goalId }, query },
        signal: deadline(),
      }),
    );
    for (const event of answer.events) if (event.type === "status") events.push(event);
    after = answer.next_after;
    if (after === null) break;
  }
  return events;
}
