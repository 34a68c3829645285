import type { Graph } from "../api/graph";
import { clientsOf } from "./filter";
import { conflictsOf, warningOf } from "./qos";
import { baseName, type Kind, thingId } from "./things";
import type { Shown } from "./view";

/** A thing as the picture shows it. */
export interface Vertex {
  /** The id that `thingId` makes. */
  id: string;
  kind: Kind;
  name: string;
  /** How many have this name. */
  count: number;
  /** What is wrong with it, in a few words. */
  warning: string | null;
}

/** An arrow in the way of the messages; for actions and services from those who ask to those who do. */
export interface Link {
  id: string;
  source: string;
  target: string;
  kind: "messages" | "action" | "service";
  /** What goes along it, where that is not at one of its ends. */
  label: string | null;
  /** Messages do not arrive. */
  broken: boolean;
}

export interface Elements {
  vertices: Vertex[];
  links: Link[];
}

/** The picture of a graph, without places. */
export function elementsOf(graph: Graph, shown: Shown): Elements {
  const nodes: Vertex[] = graph.nodes.map(({ name, count }) => vertex("node", name, { count }));
  const elements = shown === "nodes" ? nodesAlone(graph, nodes) : withTopics(graph, nodes, shown);
  addServices(graph, elements);
  const known = new Set(elements.vertices.map(({ id }) => id));
  const links = elements.links.filter(({ source, target }) => known.has(source) && known.has(target));
  return { vertices: elements.vertices, links };
}

function withTopics(graph: Graph, nodes: Vertex[], shown: Shown): Elements {
  const vertices = [...nodes];
  const links = new Links();
  for (const topic of graph.topics) {
    const { name, publishers, subscribers } = topic;
    const id = thingId({ kind: "topic", name });
    const deaf = new Set(conflictsOf(topic).map(({ subscriber }) => subscriber.node));
    vertices.push(vertex("topic", name, { warning: warningOf(topic) }));
    for (const { node } of publishers) links.add(nodeId(node), id, "messages");
    for (const { node } of subscribers) links.add(id, nodeId(node), "messages", { broken: deaf.has(node) });
  }
  for (const { name, servers, clients } of shown === "all" ? graph.actions : []) {
    const id = thingId({ kind: "action", name });
    vertices.push(vertex("action", name));
    for (const client of clients) links.add(nodeId(client), id, "action");
    for (const server of servers) links.add(id, nodeId(server), "action");
  }
  return { vertices, links: links.all };
}

/** Topics and actions become the arrows between nodes. */
function nodesAlone(graph: Graph, nodes: Vertex[]): Elements {
  const links = new Links();
  for (const topic of graph.topics) {
    const deaf = new Set(conflictsOf(topic).map(({ subscriber }) => subscriber.node));
    for (const publisher of topic.publishers) {
      for (const subscriber of topic.subscribers) {
        const how = { through: topic.name, broken: deaf.has(subscriber.node) };
        links.add(nodeId(publisher.node), nodeId(subscriber.node), "messages", how);
      }
    }
  }
  for (const { name, servers, clients } of graph.actions) {
    for (const client of clients) {
      for (const server of servers) links.add(nodeId(client), nodeId(server), "action", { through: name });
    }
  }
  return { vertices: nodes, links: links.all };
}

function addServices(graph: Graph, { vertices, links }: Elements): void {
  const clients = clientsOf(graph.nodes);
  const found = new Links();
  for (const { name, servers } of graph.services) {
    const id = thingId({ kind: "service", name });
    vertices.push(vertex("service", name));
    for (const client of clients.get(name) ?? []) found.add(nodeId(client), id, "service");
    for (const server of servers) found.add(id, nodeId(server), "service");
  }
  links.push(...found.all);
}

function vertex(kind: Kind, name: string, { count = 1, warning = null }: Partial<Vertex> = {}): Vertex {
  return { id: thingId({ kind, name }), kind, name, count, warning };
}

function nodeId(node: string | null): string {
  return thingId({ kind: "node", name: node ?? "" });
}

/** Arrows, one for each pair and kind. */
class Links {
  readonly #links = new Map<string, Link & { through: Set<string> }>();

  add(
    source: string,
    target: string,
    kind: Link["kind"],
    { through = null, broken = false }: { through?: string | null; broken?: boolean } = {},
  ): void {
    // What a node tells itself is nothing to draw.
    if (source === target) return;
    const id = `${kind} ${source} ${target}`;
    const link = this.#links.get(id) ?? {
      id,
      source,
      target,
      kind,
      label: null,
      broken: false,
      through: new Set<string>(),
    };
    link.broken ||= broken;
    if (through !== null) link.through.add(through);
    this.#links.set(id, link);
  }

  get all(): Link[] {
    return [...this.#links.values()].map(({ through, ...link }) => ({
      ...link,
      label: labelOf([...through], link.broken),
    }));
  }
}

function labelOf(names: string[], broken: boolean): string | null {
  const [first, ...others] = names.map(baseName);
  const name = first !== undefined && others.length > 0 ? `${first} +${others.length}` : first;
  return (
    [name, broken ? "does not arrive" : undefined].filter((part) => part !== undefined).join(": ") || null
  );
}
