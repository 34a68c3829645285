import { Graph as DagreGraph, layout } from "@dagrejs/dagre";
import type { Elements } from "./elements";
import { sizeOf } from "./size";

/** The upper left corner of a vertex, in pixels of the picture at its own size. */
export interface Place {
  x: number;
  y: number;
}

/** By the vertices' ids. */
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
  /** By the links' ids. */
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
