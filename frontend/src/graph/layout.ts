import { Graph as DagreGraph, layout } from "@dagrejs/dagre";
import type { Elements, Link, Vertex } from "./elements";
import { sizeOf } from "./words";

/** The upper left corner of a vertex, in pixels of the picture at its own size. */
export interface Place {
  x: number;
  y: number;
}

/** The places of vertices, by id. */
export type Places = ReadonlyMap<string, Place>;

/** The way of a link around what is between its ends, for as long as these are where they were. */
export interface Route {
  source: Place;
  target: Place;
  points: Place[];
  label: Place;
}

export interface Layout {
  places: Places;
  /** The routes of links, by id. */
  routes: ReadonlyMap<string, Route>;
}

/** Between vertices of one column, and between columns (px). */
const [BETWEEN, COLUMNS] = [18, 52];
const [LABEL_CHARACTER, LABEL_HEIGHT] = [6.6, 16];

/** Places for all of it: from left to right, as the messages go. */
export function layOut({ vertices, links }: Elements): Layout {
  const graph = new DagreGraph({ multigraph: true });
  graph.setGraph({ rankdir: "LR", nodesep: BETWEEN, edgesep: 10, ranksep: COLUMNS, marginx: 8, marginy: 8 });
  for (const vertex of vertices) graph.setNode(vertex.id, sizeOf(vertex));
  for (const { id, source, target, label } of links) {
    const size =
      label === null
        ? { width: 0, height: 0 }
        : { width: label.length * LABEL_CHARACTER, height: LABEL_HEIGHT };
    graph.setEdge(source, target, { ...size, labelpos: "c" }, id);
  }
  layout(graph);

  const places = new Map(
    vertices.map((vertex): [string, Place] => {
      const { x = 0, y = 0 } = graph.node(vertex.id);
      const { width, height } = sizeOf(vertex);
      return [vertex.id, { x: Math.round(x - width / 2), y: Math.round(y - height / 2) }];
    }),
  );
  const routes = new Map(
    links.flatMap(({ id, source, target }): [string, Route][] => {
      const { points = [], x = 0, y = 0 } = graph.edge(source, target, id);
      const [from, to] = [places.get(source), places.get(target)];
      return from && to ? [[id, { source: from, target: to, points, label: { x, y } }]] : [];
    }),
  );
  return { places, routes };
}

/** Between what is there and what comes (px). */
const GAP = 18;

/** Places where everything that had one stays; new ones come next to what they are connected with. */
export function layOutNew(elements: Elements, kept: Places): Places {
  const { vertices, links } = elements;
  const known = new Set(vertices.map(({ id }) => id));
  const places = new Map([...kept].filter(([id]) => known.has(id)));
  const fresh = vertices.filter(({ id }) => !kept.has(id));
  if (fresh.length === 0) return places.size === kept.size ? kept : places;
  const ideal = layOut(elements).places;
  if (places.size === 0) return ideal;

  for (const group of groupsOf(fresh, links)) {
    const there = boxesOf(vertices, places);
    const shift = shiftOf(group, links, ideal, places) ?? shiftBelow(group, ideal, there);
    const wanted = boxesOf(group, ideal).map((box) => ({ ...box, x: box.x + shift.x, y: box.y + shift.y }));
    const down = freeBelow(wanted, there);
    for (const { id, x, y } of wanted) places.set(id, { x, y: y + down });
  }
  return places;
}

interface Box extends Place {
  id: string;
  width: number;
  height: number;
}

function boxesOf(vertices: readonly Vertex[], places: Places): Box[] {
  return vertices.flatMap((vertex) => {
    const place = places.get(vertex.id);
    return place ? [{ id: vertex.id, ...place, ...sizeOf(vertex) }] : [];
  });
}

/** New vertices that hang together. */
function groupsOf(fresh: readonly Vertex[], links: readonly Link[]): Vertex[][] {
  const left = new Map(fresh.map((vertex) => [vertex.id, vertex]));
  const groups: Vertex[][] = [];
  for (const first of fresh) {
    if (!left.delete(first.id)) continue;
    const group = [first];
    // It grows while it is walked along.
    for (const { id } of group) {
      for (const { source, target } of links) {
        const other = left.get(source === id ? target : target === id ? source : "");
        if (other === undefined) continue;
        left.delete(other.id);
        group.push(other);
      }
    }
    groups.push(group);
  }
  return groups;
}

/** How far those that the group is connected with are from where a new layout would have them; null without any. */
function shiftOf(
  group: readonly Vertex[],
  links: readonly Link[],
  ideal: Places,
  places: Places,
): Place | null {
  const ids = new Set(group.map(({ id }) => id));
  const shifts = links.flatMap(({ source, target }): Place[] => {
    const neighbour = ids.has(source) ? target : ids.has(target) ? source : "";
    const [is, would] = [places.get(neighbour), ideal.get(neighbour)];
    return is && would ? [{ x: is.x - would.x, y: is.y - would.y }] : [];
  });
  if (shifts.length === 0) return null;
  const mean = (numbers: number[]) => Math.round(numbers.reduce((sum, one) => sum + one, 0) / numbers.length);
  return { x: mean(shifts.map(({ x }) => x)), y: mean(shifts.map(({ y }) => y)) };
}

/** Moves a group below everything, at the left. */
function shiftBelow(group: readonly Vertex[], ideal: Places, there: readonly Box[]): Place {
  const own = boxesOf(group, ideal);
  const bottom = Math.max(...there.map(({ y, height }) => y + height)) + GAP;
  return {
    x: Math.min(...there.map(({ x }) => x)) - Math.min(...own.map(({ x }) => x)),
    y: bottom - Math.min(...own.map(({ y }) => y)),
  };
}

/** How far down the boxes have to go so that they cover none of those that are there. */
function freeBelow(boxes: readonly Box[], there: readonly Box[]): number {
  let down = 0;
  for (;;) {
    const way = Math.max(...boxes.flatMap((box) => there.map((other) => overlap(box, down, other))));
    if (way <= 0) return down;
    down += way;
  }
}

/** How far a box has to go down to be clear of another one; 0 where it is. */
function overlap(box: Box, down: number, other: Box): number {
  const y = box.y + down;
  const covers =
    box.x < other.x + other.width &&
    other.x < box.x + box.width &&
    y < other.y + other.height &&
    other.y < y + box.height;
  return covers ? other.y + other.height + GAP - y : 0;
}

type Direction = "left" | "right" | "up" | "down";

const WAYS: Record<string, Direction> = {
  ArrowLeft: "left",
  ArrowRight: "right",
  ArrowUp: "up",
  ArrowDown: "down",
};

export function directionOf(key: string): Direction | null {
  return WAYS[key] ?? null;
}

/** The id of the nearest in a direction: things straight ahead are nearer than those to the side. Null where nothing is. */
export function stepFrom(places: Places, from: string, direction: Direction): string | null {
  const start = places.get(from);
  if (start === undefined) return null;
  let nearest: string | null = null;
  let least = Number.POSITIVE_INFINITY;
  for (const [id, place] of places) {
    const distance = distanceTo(start, place, direction);
    if (id !== from && distance < least) [nearest, least] = [id, distance];
  }
  return nearest;
}

function distanceTo(start: Place, end: Place, direction: Direction): number {
  const [x, y] = [end.x - start.x, end.y - start.y];
  const sideways = direction === "left" || direction === "right";
  const ahead = sideways ? x : y;
  const along = direction === "left" || direction === "up" ? -ahead : ahead;
  return along <= 0 ? Number.POSITIVE_INFINITY : along + 2 * Math.abs(sideways ? y : x);
}
