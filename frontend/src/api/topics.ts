import { deadline, type Http, settle } from "./http";
import type { components } from "./schema.gen";

export type GraphTopic = components["schemas"]["GraphTopic"];

/** A topic as it is now, with those who publish and subscribe. */
export function findTopic(http: Http, name: string): Promise<GraphTopic> {
  const path = { name: name.replace(/^\//, "") };
  return settle(http.GET("/graph/topics/{name}", { params: { path }, signal: deadline() }));
}

/** The gateway's own name on the graph. */
export async function gatewayNode(http: Http): Promise<string> {
  return (await settle(http.GET("/healthz", { signal: deadline() }))).node;
}
