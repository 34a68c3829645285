import { type Edge, MarkerType, type Node, type NodeHandle, Position } from "@xyflow/react";
import type { Elements, Link, Vertex } from "./elements";
import type { Layout, Place, Places, Route } from "./layout";
import { parseThing } from "./things";
import { sizeOf } from "./words";

/** How a thing stands out, or does not. */
type Emphasis = "selected" | "beside" | "found" | "usual" | "dimmed";

interface VertexData extends Record<string, unknown> {
  vertex: Vertex;
  emphasis: Emphasis;
  /** Whether Tab comes to it. */
  tabStop: boolean;
  onSelect: (vertex: Vertex) => void;
}

interface LinkData extends Record<string, unknown> {
  /** Null where an end is not where the route was made for. */
  route: Route | null;
}

export type VertexNode = Node<VertexData, "vertex">;
export type LinkEdge = Edge<LinkData, "link">;

interface Focus {
  /** The ids that the search has found; null without a search. */
  matching: ReadonlySet<string> | null;
  selected: string | null;
  tabStop: string | null;
}

/** Vertices as React Flow wants them: their sizes are known, so nothing has to be measured before it is drawn. */
export function flowNodes(
  elements: Elements,
  places: Places,
  focus: Focus,
  onSelect: (vertex: Vertex) => void,
): VertexNode[] {
  const beside = neighboursOf(focus.selected, elements.links);
  return elements.vertices.map((vertex) => {
    const size = sizeOf(vertex);
    return {
      id: vertex.id,
      type: "vertex",
      position: places.get(vertex.id) ?? { x: 0, y: 0 },
      ...size,
      measured: size,
      handles: handlesOf(size),
      ariaRole: "group",
      data: {
        vertex,
        emphasis: emphasisOf(vertex.id, focus, beside),
        tabStop: focus.tabStop === vertex.id,
        onSelect,
      },
    };
  });
}

/** The four ends that an arrow may have at a thing; ids as in `VertexBox`. */
function handlesOf({ width, height }: { width: number; height: number }): NodeHandle[] {
  const at = { y: height / 2, width: 1, height: 1 };
  const left = { ...at, position: Position.Left, x: 0 };
  const right = { ...at, position: Position.Right, x: width - 1 };
  return [
    { ...left, id: "left", type: "target" },
    { ...right, id: "right", type: "target" },
    { ...left, id: "left", type: "source" },
    { ...right, id: "right", type: "source" },
  ];
}

/** Arrows, each along its route, or from the side of its source that looks at its target. */
export function flowEdges(
  { vertices, links }: Elements,
  { places, routes }: Layout,
  { selected }: Pick<Focus, "selected">,
): LinkEdge[] {
  const widths = new Map(vertices.map((vertex) => [vertex.id, sizeOf(vertex).width]));
  const isBack = (source: string, target: string) =>
    (places.get(target)?.x ?? 0) + (widths.get(target) ?? 0) < (places.get(source)?.x ?? 0);
  return links.map(({ id, source, target, kind, label, broken }) => {
    const near = selected !== null && (source === selected || target === selected);
    const back = isBack(source, target);
    const route = routes.get(id);
    const holds = route && isAt(route.source, places.get(source)) && isAt(route.target, places.get(target));
    return {
      id,
      type: "link",
      source,
      target,
      sourceHandle: back ? "left" : "right",
      targetHandle: back ? "right" : "left",
      label,
      className: [kind, near ? "near" : selected === null ? "" : "far", broken ? "broken" : ""].join(" "),
      markerEnd: { type: MarkerType.ArrowClosed, width: 18, height: 18, markerUnits: "userSpaceOnUse" },
      zIndex: near ? 1 : 0,
      focusable: false,
      ariaLabel: `${parseThing(source)?.name} to ${parseThing(target)?.name}`,
      data: { route: holds ? route : null },
    };
  });
}

function isAt(place: Place, other: Place | undefined): boolean {
  return place.x === other?.x && place.y === other.y;
}

function emphasisOf(id: string, { matching, selected }: Focus, beside: ReadonlySet<string>): Emphasis {
  if (id === selected) return "selected";
  if (matching !== null) return matching.has(id) ? "found" : "dimmed";
  if (selected === null || beside.size === 0) return "usual";
  return beside.has(id) ? "beside" : "dimmed";
}

function neighboursOf(selected: string | null, links: readonly Link[]): ReadonlySet<string> {
  return new Set(
    links.flatMap(({ source, target }) =>
      source === selected ? [target] : target === selected ? [source] : [],
    ),
  );
}
