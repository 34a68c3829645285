import type { Graph } from "../api/graph";
import type { Vertex } from "./elements";
import { baseName, type Kind, namespaceOf } from "./things";

export const KIND_NAMES: Record<Kind, string> = {
  node: "Nodes",
  topic: "Topics",
  action: "Actions",
  service: "Services",
};

/** `3 topics`, `1 topic`. */
function count(number: number, noun: string): string {
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

const MAX_CHARACTERS = 25;
const MAX_LINES = 2;
const MIN_WIDTH = 96;
/** The widths of a character of the bold name, of one of the small line above it, and of the margin of both (px). */
const [CHARACTER, SMALL_CHARACTER, AROUND] = [9, 6.6, 40];
const [HEIGHT, LINE] = [46, 17];

/** `topic in /robot1`. */
export function placeWords({ kind, name, count }: Vertex): string {
  const namespace = namespaceOf(name);
  return `${count > 1 ? `${count} ${kind}s` : kind}${namespace === "/" ? "" : ` in ${namespace}`}`;
}

/** The name without its namespace in lines, broken after underscores. */
export function linesOf(name: string): string[] {
  const lines: string[] = [];
  for (const word of baseName(name).split(/(?<=_)/)) {
    const last = lines.at(-1);
    if (last !== undefined && last.length + word.length <= MAX_CHARACTERS) lines.splice(-1, 1, last + word);
    else lines.push(word);
  }
  return lines;
}

/** The box of a thing, so large that its text fits, or two lines of it (px). */
export function sizeOf(vertex: Vertex): { width: number; height: number } {
  const lines = linesOf(vertex.name);
  const text = Math.min(MAX_CHARACTERS, Math.max(...lines.map(({ length }) => length))) * CHARACTER;
  const small = Math.min(placeWords(vertex).length, MAX_CHARACTERS * 1.3) * SMALL_CHARACTER;
  return {
    width: Math.round(Math.max(MIN_WIDTH, Math.max(text, small) + AROUND)),
    height: HEIGHT + (Math.min(lines.length, MAX_LINES) - 1) * LINE,
  };
}
