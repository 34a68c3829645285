import { deadline, type Http, settle } from "./http";
import type { components } from "./schema.gen";

export type GoalNotes = components["schemas"]["GoalNotes"];
export type Note = components["schemas"]["Note"];

/** Notes and tags of a goal. Each call gives what the goal has then; every failure is a CommandError. */
export interface NotesApi {
  read(): Promise<GoalNotes>;
  add(by: string, text: string): Promise<GoalNotes>;
  remove(noteId: string): Promise<GoalNotes>;
  setTags(tags: readonly string[]): Promise<GoalNotes>;
}

export function createNotesApi(http: Http, goalId: string): NotesApi {
  const path = { goal_id: goalId };
  const options = () => ({ params: { path }, signal: deadline() });
  return {
    read: () => settle(http.GET("/goals/{goal_id}/notes", options())),
    add: (by, text) => settle(http.POST("/goals/{goal_id}/notes", { body: { by, text }, ...options() })),
    remove: (noteId) =>
      settle(
        http.DELETE("/goals/{goal_id}/notes/{note_id}", {
          params: { path: { ...path, note_id: noteId } },
          signal: deadline(),
        }),
      ),
    setTags: (tags) => settle(http.PUT("/goals/{goal_id}/tags", { body: { tags: [...tags] }, ...options() })),
  };
}

/** The tags of all goals. */
export async function listTags(http: Http): Promise<string[]> {
  return (await settle(http.GET("/goals/tags", { signal: deadline() }))).tags;
}
