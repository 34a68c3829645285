import { ClientError } from "@dock-gateway/client";
import { expect, test, vi } from "vitest";
import { readGraph } from "../src/api/graph";
import { createHttp } from "../src/api/http";
import { fleetGraph } from "./graph";

const http = createHttp("http://gateway:8000");

function answerWith(answer: (request: Request) => Response) {
  const asked = vi.fn(async (request: Request) => answer(request));
  vi.stubGlobal("fetch", asked);
  return asked;
}

function tagged(tag: string): Response {
  return Response.json(fleetGraph(), { headers: { ETag: tag } });
}

test("the first graph is asked for as it is, the next only where it has changed", async () => {
  const asked = answerWith((request) =>
    request.headers.get("If-None-Match") === '"1"' ? new Response(null, { status: 304 }) : tagged('"1"'),
  );
  const first = await readGraph(http, undefined);
  expect(first).toEqual({ graph: fleetGraph(), tag: '"1"' });
  expect(asked.mock.calls[0]?.[0].headers.has("If-None-Match")).toBe(false);
  expect(await readGraph(http, first)).toBe(first);
});

test("a graph that has changed takes its place", async () => {
  answerWith(() => tagged('"2"'));
  const last = { graph: { nodes: [], topics: [], services: [], actions: [] }, tag: '"1"' };
  expect(await readGraph(http, last)).toEqual({ graph: fleetGraph(), tag: '"2"' });
});

test("what goes wrong is an error of the gateway's words", async () => {
  const problem = { code: "ros_unavailable", title: "no ROS", detail: "it ended", status: 503 };
  answerWith(() => Response.json(problem, { status: 503 }));
  await expect(readGraph(http, undefined)).rejects.toBeInstanceOf(ClientError);
});
