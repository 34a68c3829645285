import {
  actionPath,
  type components,
  deadline,
  type Http,
  named,
  rawJson,
  settle,
} from "@dock-gateway/client";
import type { Json, JsonSchema } from "./jsonSchema";

type Schemas = components["schemas"];

/** Whether the gateway's settings let somebody use something, and if not, why. */
export type Use = Schemas["Permission"];
export type ParameterInfo = Schemas["ParameterInfo"];
export type NodeParameters = Schemas["NodeParameters"];
export type ParameterChange = Schemas["ParameterChange"];
/** A service as it is called. The schemas are null where its package is missing. */
export type ServiceInfo = Omit<Schemas["ServiceInfo"], "request" | "response"> & {
  request: JsonSchema | null;
  response: JsonSchema | null;
};
/** A topic as something is published on it. The schema is null where its package is missing. */
export type TopicInfo = Omit<Schemas["TopicInfo"], "message"> & { message: JsonSchema | null };

/** The gateway waits for a service for that long; the page a little longer. */
const CALL_S = 30;
const CALL_TIMEOUT_MS = (CALL_S + 10) * 1000;

/** Where a name on the graph is in the API; its slashes are slashes of the path. */
export function servicePath(name: string): string {
  return `/services/${actionPath(name)}`;
}

export function topicPath(name: string): string {
  return `/topics/${actionPath(name)}`;
}

export function parametersPath(node: string): string {
  return `/nodes/${actionPath(node)}/parameters`;
}

/** What can be asked of services, topics and parameters. Each call is one request; every failure is a ClientError. */
export function createCallsApi(http: Http) {
  return {
    service: (name: string): Promise<ServiceInfo> =>
      settle(
        http.GET("/services/{service}", {
          params: { path: { service: name } },
          ...named(name),
          signal: deadline(),
        }),
      ) as Promise<ServiceInfo>,
    /** @param body The request as JSON, sent as it is. */
    call: async (name: string, body: string): Promise<Json> =>
      (
        await settle(
          http.POST("/services/{service}", {
            params: { path: { service: name }, query: { timeout_s: CALL_S } },
            ...rawJson(name, body),
            signal: deadline(CALL_TIMEOUT_MS),
          }),
        )
      ).response as Json,
    topic: (name: string): Promise<TopicInfo> =>
      settle(
        http.GET("/topics/{topic}", {
          params: { path: { topic: name } },
          ...named(name),
          signal: deadline(),
        }),
      ) as Promise<TopicInfo>,
    /** Returns the number of subscriptions that it was sent to. @param body The message as JSON, sent as it is. */
    publish: async (name: string, body: string): Promise<number> =>
      (
        await settle(
          http.POST("/topics/{topic}", {
            params: { path: { topic: name } },
            ...rawJson(name, body),
            signal: deadline(),
          }),
        )
      ).subscribers,
    parameters: (node: string): Promise<NodeParameters> =>
      settle(
        http.GET("/nodes/{node}/parameters", {
          params: { path: { node } },
          ...named(node),
          signal: deadline(CALL_TIMEOUT_MS),
        }),
      ),
    /** Sets all of these or none. @param body Values by name as JSON, sent as it is. */
    setParameters: async (node: string, body: string): Promise<ParameterChange[]> =>
      (
        await settle(
          http.PATCH("/nodes/{node}/parameters", {
            params: { path: { node } },
            ...rawJson(node, body),
            signal: deadline(CALL_TIMEOUT_MS),
          }),
        )
      ).parameters,
  };
}
