import {
  type ActionInfo,
  actionPath,
  deadline,
  type Http,
  type LiveGoal,
  rawJson,
  settle,
} from "@dock-gateway/client";
import type { JsonSchema } from "./jsonSchema";

/** JSON Schemas of an action's messages. */
export interface ActionSchemas {
  goal: JsonSchema;
  result: JsonSchema;
  feedback: JsonSchema;
}

/** What can be asked of any action on the graph. Each call is one request; every failure is a ClientError. */
export function createActionsApi(http: Http) {
  return {
    list: async (): Promise<ActionInfo[]> =>
      (await settle(http.GET("/actions", { signal: deadline() }))).actions,
    /** @param type As in `package/action/Type`. */
    schemas: (type: string): Promise<ActionSchemas> => {
      const [packageName = "", , name = ""] = type.split("/");
      const path = { package: packageName, name };
      return settle(
        http.GET("/interfaces/{package}/action/{name}", { params: { path }, signal: deadline() }),
      );
    },
    /** @param body The goal message as JSON, sent as it is. */
    send: (action: string, body: string): Promise<LiveGoal> =>
      settle(
        http.POST("/actions/{name}/goals", {
          params: { path: { name: action } },
          ...rawJson(action, body),
          signal: deadline(),
        }),
      ),
    /** The newest goals of an action. */
    goals: async (action: string, limit: number): Promise<LiveGoal[]> => {
      const query = { action: [action], limit };
      return (await settle(http.GET("/goals", { params: { query }, signal: deadline() }))).goals;
    },
  };
}

/** Where goals are sent to; the slashes of the action's name are slashes of the path. */
export function goalsPath(action: string): string {
  return `/actions/${actionPath(action)}/goals`;
}
