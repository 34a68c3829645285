import {
  type components,
  deadline,
  type GoalHistory,
  type GoalPage,
  type Http,
  type LiveGoal,
  type PoseEvent,
  type paths,
  settle,
} from "@dock-gateway/client";
import { apiPath } from "./site";

/** What `GET /goals` can be narrowed by. */
export type GoalQuery = Omit<NonNullable<paths["/goals"]["get"]["parameters"]["query"]>, "limit" | "cursor">;

/** The number of goals, or of events of a history, in one answer. */
const PAGE = 50;
const EVENTS = 2000;

/** Goals on any action, sent by whomever. Every failure is a ClientError. */
export function createGoalsApi(http: Http) {
  const one = (goalId: string) => ({ params: { path: { goal_id: goalId } }, signal: deadline() });
  return {
    list: (query: GoalQuery, cursor: string | null): Promise<GoalPage> =>
      settle(
        http.GET("/goals", {
          params: { query: { ...query, limit: PAGE, ...(cursor === null ? {} : { cursor }) } },
          signal: deadline(),
        }),
      ),
    goal: (goalId: string): Promise<LiveGoal> => settle(http.GET("/goals/{goal_id}", one(goalId))),
    cancel: (goalId: string): Promise<LiveGoal> => settle(http.POST("/goals/{goal_id}/cancel", one(goalId))),
    /** A page of what happened to a goal, oldest first, after an event, from the beginning for null. */
    history: (goalId: string, after: string | null): Promise<GoalHistory> =>
      settle(
        http.GET("/goals/{goal_id}/history", {
          params: {
            path: { goal_id: goalId },
            query: { limit: EVENTS, ...(after === null ? {} : { after }) },
          },
          signal: deadline(),
        }),
      ),
    /** Where the robot was while a goal ran, oldest first; all that is stored. */
    poses: async (goalId: string): Promise<PoseEvent[]> => {
      const poses: PoseEvent[] = [];
      for await (const { events } of historyOf(http, goalId, "pose"))
        poses.push(...events.filter((event) => event.type === "pose"));
      return poses;
    },
  };
}

/** The pages of one kind of events in a goal's history, oldest first. */
async function* historyOf(http: Http, goalId: string, type: "pose" | "status"): AsyncGenerator<GoalHistory> {
  let after: string | null = null;
  do {
    const query = { type: [type], limit: EVENTS, ...(after === null ? {} : { after }) };
    const params = { path: { goal_id: goalId }, query };
    const page: GoalHistory = await settle(
      http.GET("/goals/{goal_id}/history", { params, signal: deadline() }),
    );
    yield page;
    after = page.next_after;
  } while (after !== null);
}

export type GoalsApi = ReturnType<typeof createGoalsApi>;

export type ExportFormat = "csv" | "json";

/** Where the goals that a list is narrowed to are downloaded. */
export function goalsExportUrl(query: GoalQuery, format: ExportFormat): string {
  const parameters = new URLSearchParams({ format });
  for (const [name, value] of Object.entries(query)) {
    for (const each of Array.isArray(value) ? value : [value]) parameters.append(name, String(each));
  }
  return apiPath(`/goals/export?${parameters}`);
}

/** Where one goal with its events is downloaded. */
export function goalExportUrl(goalId: string, format: ExportFormat): string {
  return apiPath(`/goals/${encodeURIComponent(goalId)}/export?format=${format}`);
}

export type Note = components["schemas"]["Note"];

export type GoalTags = components["schemas"]["GoalTags"];

/** What people say about a goal. */
export interface GoalNotes {
  tags: GoalTags;
  notes: Note[];
}

/** Notes and tags of a goal. Every failure is a ClientError. */
export function createNotesApi(http: Http, goalId: string) {
  const path = { goal_id: goalId };
  const options = () => ({ params: { path }, signal: deadline() });
  return {
    /** Null while the gateway cannot tell. */
    read: async (): Promise<GoalNotes | null> => {
      const { notes } = await settle(http.GET("/goals/{goal_id}", options()));
      return notes == null
        ? null
        : { tags: await settle(http.GET("/goals/{goal_id}/tags", options())), notes };
    },
    add: (by: string, text: string): Promise<Note> =>
      settle(http.POST("/goals/{goal_id}/notes", { body: { by, text }, ...options() })),
    remove: (noteId: string): Promise<unknown> =>
      settle(
        http.DELETE("/goals/{goal_id}/notes/{note_id}", {
          params: { path: { ...path, note_id: noteId } },
          signal: deadline(),
        }),
      ),
    /** Replaces tags, unless someone else has changed them meanwhile. */
    setTags: (replaced: GoalTags, tags: readonly string[]): Promise<GoalTags> =>
      settle(
        http.PUT("/goals/{goal_id}/tags", {
          body: { tags: [...tags] },
          params: { path, header: { "If-Match": replaced.etag } },
          signal: deadline(),
        }),
      ),
  };
}

export type NotesApi = ReturnType<typeof createNotesApi>;

/** The tags of all goals. */
export async function listTags(http: Http): Promise<string[]> {
  return (await settle(http.GET("/goals/tags", { signal: deadline() }))).tags;
}

type Schemas = components["schemas"];

type StatusEvent = Extract<Schemas["GoalHistory"]["events"][number], { type: "status" }>;

/** A goal has a status event for each stage; more than this many pages of them is a server that runs wild. */
const MAX_PAGES = 5;

/** The statuses of a goal with its stages, oldest first. */
interface Statuses {
  events: StatusEvent[];
  /** False where the history does not reach back to the goal's beginning. */
  complete: boolean;
}

/** Every status of a goal that the history has. */
export async function statusesOf(http: Http, goalId: string): Promise<Statuses> {
  const events: StatusEvent[] = [];
  let [complete, pages] = [true, 0];
  for await (const page of historyOf(http, goalId, "status")) {
    events.push(...page.events.filter((event) => event.type === "status"));
    complete &&= page.complete;
    pages += 1;
    if (pages === MAX_PAGES) break;
  }
  return { events, complete };
}
