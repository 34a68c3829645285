import { deadline, type Http, settle } from "./http";
import type { JsonSchema } from "./jsonSchema";
import type { ActionInfo, AnyGoal } from "./types";

/** JSON Schemas of an action's messages. */
export interface ActionSchemas {
  goal: JsonSchema;
  result: JsonSchema;
  feedback: JsonSchema;
}

/** What can be asked of any action on the graph. Each call is one request; every failure is a CommandError. */
export interface ActionsApi {
  list(): Promise<ActionInfo[]>;
  /** @param type As in `package/action/Type`. */
  schemas(type: string): Promise<ActionSchemas>;
  /** @param body The goal message as JSON, sent as it is. */
  send(action: string, body: string): Promise<AnyGoal>;
  /** The newest goals of an action. */
  goals(action: string, limit: number): Promise<AnyGoal[]>;
}

export function createActionsApi(http: Http): ActionsApi {
  return {
    list: async () => (await settle(http.GET("/actions", { signal: deadline() }))).actions,
    schemas: (type) => {
      const [packageName = "", , name = ""] = type.split("/");
      const path = { package: packageName, name };
      return settle(
        http.GET("/interfaces/{package}/action/{name}", { params: { path }, signal: deadline() }),
      );
    },
    send: (action, body) =>
      settle(
        http.POST("/actions/{name}/goals", {
          params: { path: { name: action } },
          pathSerializer: (path) => path.replace("{name}", actionPath(action)),
          body: {},
          bodySerializer: () => body,
          signal: deadline(),
        }),
      ),
    goals: async (action, limit) => {
      const query = { action: [action], limit };
      return (await settle(http.GET("/goals", { params: { query }, signal: deadline() }))).goals;
    },
  };
}

/** Where goals are sent to; the slashes of the action's name are slashes of the path. */
export function goalsPath(action: string): string {
  return `/actions/${actionPath(action)}/goals`;
}

/** `/robot1/dock` as a part of a path: `robot1/dock`. */
export function actionPath(action: string): string {
  return action.replace(/^\//, "").split("/").map(encodeURIComponent).join("/");
}
