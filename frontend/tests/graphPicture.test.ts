import { expect, test } from "vitest";
import type { Graph } from "../src/api/graph";
import { type Elements, elementsOf } from "../src/graph/elements";
import { filterGraph } from "../src/graph/filter";
import { flowEdges, flowNodes } from "../src/graph/flow";
import { layOut, layOutNew, type Place, type Places, stepFrom } from "../src/graph/layout";
import { levelPath } from "../src/graph/VertexBox";
import { graphView } from "../src/graph/view";
import { linesOf, sizeOf } from "../src/graph/words";
import { endpoint, fleetGraph, node, topic } from "./graph";

const EMPTY: Graph = { nodes: [], topics: [], services: [], actions: [] };

function arrows({ links }: Elements): string[] {
  return links.map(
    ({ source, target, label }) => `${source} → ${target}${label === null ? "" : ` (${label})`}`,
  );
}

/** A talker that `names` listen to. */
function talk(...names: string[]): Graph {
  return {
    ...EMPTY,
    nodes: [node("/talker"), ...names.map((name) => node(name))],
    topics: [
      topic("/chatter", {
        publishers: [endpoint("/talker")],
        subscribers: names.map((name) => endpoint(name)),
      }),
    ],
  };
}

function overlaps(elements: Elements, places: Places): string[] {
  const boxes = elements.vertices.map((vertex) => ({
    id: vertex.id,
    ...(places.get(vertex.id) as Place),
    ...sizeOf(vertex),
  }));
  return boxes.flatMap((a, index) =>
    boxes
      .slice(index + 1)
      .filter(
        (b) => a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height,
      )
      .map((b) => `${a.id} ${b.id}`),
  );
}

test("messages go from publishers through topics to subscribers", () => {
  const elements = elementsOf(talk("/listener"), "topics");
  expect(elements.vertices.map(({ id }) => id)).toEqual(["node:/talker", "node:/listener", "topic:/chatter"]);
  expect(arrows(elements)).toEqual(["node:/talker → topic:/chatter", "topic:/chatter → node:/listener"]);
});

test("nodes alone have one arrow for all that goes from one to the other", () => {
  const graph = talk("/listener");
  graph.topics.push(
    topic("/more", {
      publishers: [endpoint("/talker")],
      subscribers: [endpoint("/listener"), endpoint("/talker")],
    }),
  );
  graph.actions.push({
    name: "/fibonacci",
    types: [],
    servers: ["/listener"],
    clients: ["/talker"],
    hidden: false,
  });
  expect(arrows(elementsOf(graph, "nodes"))).toEqual([
    "node:/talker → node:/listener (chatter +1)",
    "node:/talker → node:/listener (fibonacci)",
  ]);
});

test("actions and services go from those who ask to those who do", () => {
  const graph = fleetGraph();
  const all = arrows(elementsOf(graph, "all"));
  expect(all).toContain("node:/dock_gateway → action:/robot1/connect_to_charging_dock");
  expect(all).toContain("action:/robot1/connect_to_charging_dock → node:/robot1/docking_server");
  expect(all).toContain("node:/fleet_manager → service:/robot1/reset");
  expect(arrows(elementsOf(graph, "topics")).filter((arrow) => arrow.includes("action:"))).toEqual([]);
});

test("no arrow leads to what is not shown", () => {
  const shown = filterGraph(fleetGraph(), { ...graphView.initial, gatewayNode: "/dock_gateway" });
  const { vertices, links } = elementsOf(shown, "all");
  const ids = new Set(vertices.map(({ id }) => id));
  expect(links.flatMap(({ source, target }) => [source, target]).filter((id) => !ids.has(id))).toEqual([]);
});

test("an arrow along which nothing arrives says so", () => {
  const graph = talk("/listener");
  graph.topics[0]?.publishers.splice(0, 1, endpoint("/talker", { reliability: "best_effort" }));
  const elements = elementsOf(graph, "topics");
  expect(elements.vertices[2]?.warning).toBe("incompatible QoS");
  const edges = flowEdges(elements, layOut(elements), { selected: null });
  expect(edges.map(({ label }) => label)).toEqual([null, "does not arrive"]);
});

test("a layout goes from left to right and covers nothing", () => {
  const elements = elementsOf(fleetGraph(), "all");
  const { places, routes } = layOut(elements);
  const x = (id: string) => places.get(id)?.x ?? Number.NaN;
  expect(x("node:/robot1/battery")).toBeLessThan(x("topic:/robot1/battery_status"));
  expect(x("topic:/robot1/battery_status")).toBeLessThan(x("node:/robot1/docking_server"));
  expect(overlaps(elements, places)).toEqual([]);
  expect(routes.size).toBe(elements.links.length);
});

test("what stays keeps its place, and what comes covers nothing", () => {
  const before = elementsOf(talk("/a", "/b"), "topics");
  const dragged = new Map([...layOut(before).places, ["node:/a", { x: 700, y: -300 }]]);
  const graph = talk("/a", "/c", "/d");
  graph.nodes.push(node("/far/away"));
  const after = elementsOf(graph, "topics");
  const places = layOutNew(after, dragged);
  for (const id of ["node:/talker", "topic:/chatter", "node:/a"])
    expect(places.get(id)).toEqual(dragged.get(id));
  expect([...places.keys()].sort()).toEqual(after.vertices.map(({ id }) => id).sort());
  expect(overlaps(after, places)).toEqual([]);
});

test("the same things have the same places, in the same object", () => {
  const elements = elementsOf(talk("/a"), "topics");
  const { places } = layOut(elements);
  expect(layOutNew(elementsOf(talk("/a"), "topics"), places)).toBe(places);
});

test("an arrow leaves its route once an end is moved", () => {
  const elements = elementsOf(talk("/a"), "topics");
  const layout = layOut(elements);
  const routed = (places: Places) =>
    flowEdges(elements, { ...layout, places }, { selected: null }).map(({ data }) => data?.route !== null);
  expect(routed(layout.places)).toEqual([true, true]);
  expect(routed(new Map([...layout.places, ["node:/a", { x: -900, y: 0 }]]))).toEqual([true, false]);
});

test("an arrow back begins at the left", () => {
  const elements = elementsOf(talk("/a"), "topics");
  const places = new Map([...layOut(elements).places, ["node:/a", { x: -900, y: 0 }]]);
  const [, back] = flowEdges(elements, { places, routes: new Map() }, { selected: null });
  expect([back?.sourceHandle, back?.targetHandle]).toEqual(["left", "right"]);
});

test("what is beside the selected thing stands out, the rest does not; a search counts more", () => {
  const elements = elementsOf(talk("/a", "/b"), "topics");
  const { places } = layOut(elements);
  const emphases = (matching: ReadonlySet<string> | null, selected: string | null) =>
    Object.fromEntries(
      flowNodes(elements, places, { matching, selected, tabStop: null }, () => {}).map(({ id, data }) => [
        id,
        data.emphasis,
      ]),
    );
  expect(emphases(null, "node:/a")).toEqual({
    "node:/talker": "dimmed",
    "node:/a": "selected",
    "node:/b": "dimmed",
    "topic:/chatter": "beside",
  });
  expect(emphases(new Set(["node:/b"]), "node:/a")).toMatchObject({
    "node:/b": "found",
    "node:/a": "selected",
    "topic:/chatter": "dimmed",
  });
});

test("arrow keys go to what is straight ahead first", () => {
  const places = new Map([
    ["start", { x: 0, y: 0 }],
    ["ahead", { x: 300, y: 10 }],
    ["aside", { x: 200, y: 150 }],
    ["below", { x: 0, y: 200 }],
  ]);
  expect(stepFrom(places, "start", "right")).toBe("ahead");
  expect(stepFrom(places, "start", "down")).toBe("below");
  expect(stepFrom(places, "start", "left")).toBeNull();
  expect(stepFrom(places, "nobody", "left")).toBeNull();
});

test("names break after underscores; what is longer than two lines makes no larger box", () => {
  expect(linesOf("/robot1/battery_status")).toEqual(["battery_status"]);
  const server = "/connect_to_charging_dock_action_server";
  expect(linesOf(server)).toEqual(["connect_to_charging_dock_", "action_server"]);
  const size = (name: string) => sizeOf({ id: "", kind: "topic", name, count: 1, warning: null });
  expect(size(server).height).toBeGreaterThan(size("/odom").height);
  expect(size(`${server}_with_more_words_than_anybody_reads`).height).toBe(size(server).height);
  expect(size(`/${"a".repeat(80)}`).width).toBe(size(`/${"a".repeat(25)}`).width);
});

test("a route is level at its points", () => {
  expect(
    levelPath([
      { x: 0, y: 0 },
      { x: 10, y: 5 },
    ]),
  ).toBe("M 0 0 C 5 0 5 5 10 5");
  expect(levelPath([])).toBe("");
});
