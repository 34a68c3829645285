import { expect, test } from "vitest";
import { type Filters, filterGraph, namespacesOf, searchGraph } from "../src/graph/filter";
import { isWithin, matches, parseThing, thingId } from "../src/graph/things";
import { type GraphView, graphView } from "../src/graph/view";
import { fleetGraph } from "./graph";

const USUAL: Filters = {
  namespace: "/",
  hidden: false,
  services: false,
  gateway: false,
  gatewayNode: "/dock_gateway",
};

function names(change: Partial<Filters>) {
  const { nodes, topics, services, actions } = filterGraph(fleetGraph(), { ...USUAL, ...change });
  const of = (things: { name: string }[]) => things.map(({ name }) => name);
  return { nodes: of(nodes), topics: of(topics), services: of(services), actions: of(actions) };
}

test("noise and the gateway are left out, and what only the gateway has", () => {
  expect(names({})).toEqual({
    nodes: [
      "/fleet_manager",
      "/robot1/battery",
      "/robot1/docking_server",
      "/robot2/battery",
      "/robot2/docking_server",
    ],
    topics: ["/robot1/battery_status", "/robot2/battery_status"],
    services: [],
    actions: ["/robot1/connect_to_charging_dock", "/robot2/connect_to_charging_dock"],
  });
});

test("each switch brings its things back", () => {
  expect(names({ gateway: true }).nodes).toContain("/dock_gateway");
  expect(names({ gateway: true }).topics).toContain("/stop_latched");
  expect(names({ hidden: true }).topics).toContain("/rosout");
  expect(names({ services: true }).services).toEqual(["/robot1/reset", "/robot2/reset"]);
  expect(names({ services: true, hidden: true }).services).toHaveLength(4);
});

test("a namespace shows what is in it and what that is connected with", () => {
  const robot = names({ namespace: "/robot1", services: true, gateway: true });
  expect(robot.nodes).toEqual([
    "/dock_gateway",
    "/fleet_manager",
    "/robot1/battery",
    "/robot1/docking_server",
  ]);
  expect(robot.topics).toEqual(["/robot1/battery_status"]);
  expect(robot.actions).toEqual(["/robot1/connect_to_charging_dock"]);
});

test("a topic that all robots share does not bring the others into a namespace", () => {
  const robot = names({ namespace: "/robot1", hidden: true });
  expect(robot.topics).toContain("/rosout");
  expect(robot.nodes.filter((name) => name.startsWith("/robot2"))).toEqual([]);
});

test("namespaces are those with something in them; names of nodes are none", () => {
  expect(namespacesOf(fleetGraph())).toEqual(["/", "/robot1", "/robot2"]);
  expect(isWithin("/robot10/battery", "/robot1")).toBe(false);
});

test("a search looks at names and types, each word by itself", () => {
  expect(searchGraph(fleetGraph(), "robot2 batterystate").topics.map(({ name }) => name)).toEqual([
    "/robot2/battery_status",
  ]);
  expect(searchGraph(fleetGraph(), "nothing like it").nodes).toEqual([]);
  const graph = fleetGraph();
  expect(searchGraph(graph, "  ")).toBe(graph);
  expect(matches("DOCK", "/docking_server")).toBe(true);
});

test("the address says all that is shown, and nothing where all is as usual", () => {
  const view: GraphView = {
    form: "list",
    shown: "nodes",
    namespace: "/robot1",
    search: "battery state",
    hidden: true,
    services: true,
    gateway: true,
    selected: { kind: "topic", name: "/robot1/battery_status" },
    echo: true,
  };
  expect(graphView.read(new URLSearchParams(graphView.write(view).toString()))).toEqual(view);
  expect(graphView.write(graphView.initial).toString()).toBe("");
  expect(graphView.read(new URLSearchParams())).toEqual(graphView.initial);
});

test("nonsense in the address is as if it were not there", () => {
  expect(
    graphView.read(new URLSearchParams("view=3d&show=x&namespace=robot1&selected=car:/x&hidden=1")),
  ).toEqual(graphView.initial);
  expect(parseThing("topic:/a:b")).toEqual({ kind: "topic", name: "/a:b" });
  expect(thingId({ kind: "node", name: "/x" })).toBe("node:/x");
});
