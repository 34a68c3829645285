import { type components, deadline, type Http, settle } from "@dock-gateway/client";

type Schemas = components["schemas"];
export type Graph = Schemas["Graph"];
export type GraphNode = Schemas["GraphNode"];
export type GraphTopic = Schemas["GraphTopic"];
export type GraphService = Schemas["GraphService"];
export type GraphAction = Schemas["GraphAction"];

/** A publisher or a subscriber; without a node it belongs to a DDS program that is no ROS node. */
export type Endpoint = Schemas["TopicEndpoint"];

/** Null is not known for a depth, and without limit for seconds. */
export type Quality = Schemas["TopicQuality"];

/** The ROS graph, with the tag by which the gateway knows whether it has changed. */
export interface TaggedGraph {
  graph: Graph;
  tag: string | null;
}

/** The graph as it is now; the same object where nothing has changed since `last`. Throws a ClientError. */
export async function readGraph(http: Http, last: TaggedGraph | undefined): Promise<TaggedGraph> {
  let changed = true;
  let tag: string | null = null;
  const headers = last?.tag ? { "If-None-Match": last.tag } : {};
  const request = http.GET("/graph", { headers, signal: deadline() }).then((answer) => {
    changed = answer.response.status !== 304;
    tag = answer.response.headers.get("ETag");
    // "Not Modified" is no error here.
    return changed ? answer : { response: new Response(null) };
  });
  const graph = await settle(request);
  return changed || last === undefined ? { graph: graph as Graph, tag } : last;
}

/** A topic as it is now, with those who publish and subscribe. */
export function findTopic(http: Http, name: string): Promise<GraphTopic> {
  const path = { name: name.replace(/^\//, "") };
  return settle(http.GET("/graph/topics/{name}", { params: { path }, signal: deadline() }));
}

/** The gateway's own name on the graph. */
export async function gatewayNode(http: Http): Promise<string> {
  return (await settle(http.GET("/healthz", { signal: deadline() }))).node;
}
