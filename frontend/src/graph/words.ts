import type { Graph } from "../api/graph";
import type { Vertex } from "./elements";
import { placeWords } from "./size";
import { baseName, type Kind } from "./things";

export const KIND_NAMES: Record<Kind, string> = {
  node: "Nodes",
  topic: "Topics",
  action: "Actions",
  service: "Services",
};

/** `3 topics`, `1 topic`. */
export function count(number: number, noun: string): string {
  return `${number} ${noun}${number === 1 ? "" : "s"}`;
}

/** What of the graph is shown: `4 of 6 nodes, 9 of 23 topics, 2 actions`. */
export function describeShown(shown: Graph, all: Graph): string {
  const part = (some: unknown[], every: unknown[], noun: string) =>
    some.length === every.length
      ? count(every.length, noun)
      : `${some.length} of ${count(every.length, noun)}`;
  const parts = [
    part(shown.nodes, all.nodes, "node"),
    part(shown.topics, all.topics, "topic"),
    part(shown.actions, all.actions, "action"),
  ];
  if (shown.services.length > 0) parts.push(part(shown.services, all.services, "service"));
  return parts.join(", ");
}

/** What a screen reader says of a thing in the picture; begins with what is seen, for those who speak to the computer. */
export function describeVertex(vertex: Vertex): string {
  const { name, warning } = vertex;
  return `${placeWords(vertex)} ${baseName(name)}${warning === null ? "" : `, warning: ${warning}`}`;
}
