import type { Graph, GraphNode, GraphTopic } from "../api/graph";
import { isWithin, matches, namespaceOf } from "./things";
import type { GraphView } from "./view";

export interface Filters extends Pick<GraphView, "namespace" | "hidden" | "services" | "gateway"> {
  /** The node of the gateway, which is at nearly every topic; other gateways mostly have the same name. */
  gatewayNode: string;
}

/** What of the graph is shown. Things that only left-out nodes have are left out too. */
export function filterGraph(graph: Graph, filters: Filters): Graph {
  const quiet = withoutNoise(graph, filters);
  return filters.namespace === "/" ? quiet : within(quiet, filters.namespace);
}

/** The things whose name or type has all words of a search. */
export function searchGraph(graph: Graph, query: string): Graph {
  if (query.trim() === "") return graph;
  const found = ({ name, types }: { name: string; types: string[] }) => matches(query, name, ...types);
  return {
    nodes: graph.nodes.filter(({ name }) => matches(query, name)),
    topics: graph.topics.filter(found),
    services: graph.services.filter(found),
    actions: graph.actions.filter(found),
  };
}

/** Every namespace that has something in it, with those above. */
export function namespacesOf(graph: Graph): string[] {
  const found = new Set<string>(["/"]);
  const nodes = graph.nodes.map(({ name }) => name);
  for (const { name } of [...graph.nodes, ...graph.topics, ...graph.services, ...graph.actions]) {
    // What is below a node's name, as most services are, is that node's own.
    const own = name.includes("/_") || nodes.some((node) => isWithin(name, node));
    for (let above = namespaceOf(name); !own && above !== "/"; above = namespaceOf(above)) found.add(above);
  }
  return [...found].sort();
}

function withoutNoise(graph: Graph, { hidden, services, gateway, gatewayNode }: Filters): Graph {
  const nodes = graph.nodes.filter(
    (node) => (hidden || !node.hidden) && (gateway || node.name !== gatewayNode),
  );
  const shown = new Set(nodes.map(({ name }) => name));
  const known = new Set(graph.nodes.map(({ name }) => name));
  // Endpoints without a node on the graph count: they are not the gateway's.
  const has = (names: readonly (string | null)[]) =>
    names.length === 0 || names.some((name) => name === null || shown.has(name) || !known.has(name));
  const clients = clientsOf(graph.nodes);
  return {
    nodes,
    topics: graph.topics.filter(
      (topic) => (hidden || !topic.hidden) && (topic.types.length === 0 || has(nodesAt(topic))),
    ),
    services: services
      ? graph.services.filter(
          (service) =>
            (hidden || !service.hidden) && has([...service.servers, ...(clients.get(service.name) ?? [])]),
        )
      : [],
    actions: graph.actions.filter(
      (action) => (hidden || !action.hidden) && has([...action.servers, ...action.clients]),
    ),
  };
}

/** What is in a namespace, and what it is connected with. */
function within(graph: Graph, namespace: string): Graph {
  const inside = new Set(graph.nodes.map(({ name }) => name).filter((name) => isWithin(name, namespace)));
  const touches = (name: string, nodes: readonly (string | null)[]) =>
    isWithin(name, namespace) || nodes.some((node) => node !== null && inside.has(node));
  const clients = clientsOf(graph.nodes);
  const topics = graph.topics.filter((topic) => touches(topic.name, nodesAt(topic)));
  const services = graph.services.filter(({ name, servers }) =>
    touches(name, [...servers, ...(clients.get(name) ?? [])]),
  );
  const actions = graph.actions.filter(({ name, servers, clients }) =>
    touches(name, [...servers, ...clients]),
  );
  const own = new Set(
    [...topics, ...services, ...actions].map(({ name }) => name).filter((name) => isWithin(name, namespace)),
  );
  const nodes = graph.nodes.filter(
    (node) => inside.has(node.name) || everythingOf(node).some((name) => own.has(name)),
  );
  return { nodes, topics, services, actions };
}

function nodesAt(topic: GraphTopic): (string | null)[] {
  return [...topic.publishers, ...topic.subscribers].map(({ node }) => node);
}

function everythingOf(node: GraphNode): string[] {
  return [
    ...node.publishers,
    ...node.subscribers,
    ...node.services,
    ...node.clients,
    ...node.action_servers,
    ...node.action_clients,
  ];
}

/** The nodes that ask each service. */
export function clientsOf(nodes: readonly GraphNode[]): Map<string, string[]> {
  const clients = new Map<string, string[]>();
  for (const node of nodes) {
    for (const service of node.clients) clients.set(service, [...(clients.get(service) ?? []), node.name]);
  }
  return clients;
}
