/** The kinds of things on the graph, in the order in which they are listed. */
export const KINDS = ["node", "topic", "action", "service"] as const;

export type Kind = (typeof KINDS)[number];

/** A thing on the graph: kind and name, since a node and a topic may have the same name. */
export interface Thing {
  kind: Kind;
  name: string;
}

/** `topic:/battery_status`: also what stands in the page's address. */
export function thingId({ kind, name }: Thing): string {
  return `${kind}:${name}`;
}

export function parseThing(id: string | null): Thing | null {
  const [, kind, name] = /^([a-z]+):(\/.*)$/.exec(id ?? "") ?? [];
  return name !== undefined && isKind(kind) ? { kind, name } : null;
}

function isKind(text: string | undefined): text is Kind {
  return KINDS.some((kind) => kind === text);
}

/** `/robot1/docking_server` → `/robot1`; `/` where there is none. */
export function namespaceOf(name: string): string {
  return name.slice(0, Math.max(1, name.lastIndexOf("/")));
}

/** `/robot1/docking_server` → `docking_server`. */
export function baseName(name: string): string {
  return name.slice(name.lastIndexOf("/") + 1);
}

/** Whether a name is in the namespace, or below. */
export function isWithin(name: string, namespace: string): boolean {
  return namespace === "/" || name.startsWith(`${namespace}/`);
}

/** Whether all words of `query` are in one of the texts, whatever their case; an empty query matches everything. */
export function matches(query: string, ...texts: readonly string[]): boolean {
  const text = texts.join(" ").toLowerCase();
  return query
    .toLowerCase()
    .split(/\s+/)
    .every((word) => text.includes(word));
}
