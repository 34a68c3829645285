import type { Elements, Link, Vertex } from "./elements";
import { layOut, type Place, type Places } from "./layout";
import { sizeOf } from "./size";

/** Between what is there and what comes (px). */
const GAP = 18;

/** Places where everything that had one stays; what is new comes beside what it is connected with. */
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

/** Below everything, at the left. */
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
