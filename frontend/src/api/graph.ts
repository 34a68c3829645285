import { deadline, type Http, settle } from "./http";
import type { components } from "./schema.gen";

/** The ROS graph, with the tag by which the gateway knows whether it has changed. */
export interface TaggedGraph {
  graph: components["schemas"]["Graph"];
  tag: string | null;
}

/** The graph as it is now; the same object where nothing has changed since `last`. Throws a CommandError. */
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
  return changed || last === undefined ? { graph: graph as TaggedGraph["graph"], tag } : last;
}
