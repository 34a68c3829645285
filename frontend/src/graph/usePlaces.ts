import { useCallback, useState } from "react";
import type { Elements } from "./elements";
import { type Layout, layOut, type Place } from "./layout";
import { layOutNew } from "./layoutNew";

interface Laid extends Layout {
  elements: Elements;
  arrangement: string;
  /** How often all of it was laid out anew. */
  times: number;
}

export interface Arranged extends Layout {
  times: number;
  move: (moved: ReadonlyMap<string, Place>) => void;
  rearrange: () => void;
}

/**
 * The places of all elements. What is there stays where it is, also where somebody has dragged it to, until another
 * arrangement is shown or all of it is laid out anew.
 */
export function usePlaces(elements: Elements, arrangement: string): Arranged {
  const [laid, setLaid] = useState<Laid>(() => ({ ...layOut(elements), elements, arrangement, times: 0 }));
  let current = laid;
  if (laid.arrangement !== arrangement) {
    current = { ...layOut(elements), elements, arrangement, times: laid.times + 1 };
  } else if (laid.elements !== elements) {
    current = { ...laid, elements, places: layOutNew(elements, laid.places) };
  }
  if (current !== laid) setLaid(current);

  const move = useCallback(
    (moved: ReadonlyMap<string, Place>) =>
      setLaid((before) => ({ ...before, places: new Map([...before.places, ...moved]) })),
    [],
  );
  const rearrange = useCallback(
    () => setLaid((before) => ({ ...before, ...layOut(before.elements), times: before.times + 1 })),
    [],
  );
  const { places, routes, times } = current;
  return { places, routes, times, move, rearrange };
}
