import { deadline, type Http, settle } from "./http";
import type { paths } from "./schema.gen";
import type { AnyGoal, AnyGoalPage, GoalHistory, PoseEvent } from "./types";

/** What `GET /goals` can be narrowed by. */
export type GoalQuery = Omit<NonNullable<paths["/goals"]["get"]["parameters"]["query"]>, "limit" | "cursor">;

/** Goals on any action, sent by whomever. Every failure is a CommandError. */
export interface GoalsApi {
  list(query: GoalQuery, cursor: string | null): Promise<AnyGoalPage>;
  goal(goalId: string): Promise<AnyGoal>;
  cancel(goalId: string): Promise<AnyGoal>;
  /** A page of what happened to a goal, oldest first, after an event, from the beginning for null. */
  history(goalId: string, after: string | null): Promise<GoalHistory>;
  /** Where the robot was while a goal ran, oldest first; all that is stored. */
  poses(goalId: string): Promise<PoseEvent[]>;
}

/** Of the goals of a list, and of the events of a history, that come at once. */
const PAGE = 50;
const EVENTS = 2000;

export function createGoalsApi(http: Http): GoalsApi {
  const one = (goalId: string) => ({ params: { path: { goal_id: goalId } }, signal: deadline() });
  return {
    list: (query, cursor) =>
      settle(
        http.GET("/goals", {
          params: { query: { ...query, limit: PAGE, ...(cursor === null ? {} : { cursor }) } },
          signal: deadline(),
        }),
      ),
    goal: (goalId) => settle(http.GET("/goals/{goal_id}", one(goalId))),
    cancel: (goalId) => settle(http.POST("/goals/{goal_id}/cancel", one(goalId))),
    history: (goalId, after) =>
      settle(
        http.GET("/goals/{goal_id}/history", {
          params: {
            path: { goal_id: goalId },
            query: { limit: EVENTS, ...(after === null ? {} : { after }) },
          },
          signal: deadline(),
        }),
      ),
    poses: async (goalId) => {
      const poses: PoseEvent[] = [];
      let after: string | null = null;
      do {
        const page: GoalHistory = await settle(
          http.GET("/goals/{goal_id}/history", {
            params: {
              path: { goal_id: goalId },
              query: { type: ["pose"], limit: EVENTS, ...(after === null ? {} : { after }) },
            },
            signal: deadline(),
          }),
        );
        poses.push(...page.events.filter((event) => event.type === "pose"));
        after = page.next_after;
      } while (after !== null);
      return poses;
    },
  };
}

export type ExportFormat = "csv" | "json";

/** Where the goals that a list is narrowed to are downloaded. */
export function goalsExportUrl(query: GoalQuery, format: ExportFormat): string {
  const parameters = new URLSearchParams({ format });
  for (const [name, value] of Object.entries(query)) {
    for (const each of Array.isArray(value) ? value : [value]) parameters.append(name, String(each));
  }
  return `/goals/export?${parameters}`;
}

/** Where one goal with its events is downloaded. */
export function goalExportUrl(goalId: string, format: ExportFormat): string {
  return `/goals/${encodeURIComponent(goalId)}/export?format=${format}`;
}
