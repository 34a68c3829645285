import { type FitViewOptions, useReactFlow } from "@xyflow/react";
import { type RefObject, useCallback, useEffect, useRef, useState } from "react";
import type { Elements } from "./elements";
import type { VertexNode } from "./flow";
import { type Layout, layOut, layOutNew, type Place } from "./layout";

interface Laid extends Layout {
  elements: Elements;
  arrangement: string;
  /** The number of times that all of it was laid out again. */
  times: number;
}

interface Arranged extends Layout {
  times: number;
  move: (moved: ReadonlyMap<string, Place>) => void;
  rearrange: () => void;
}

/**
 * The places of all elements. What is there stays where it is, also where somebody has dragged it to, until another
 * arrangement is shown or all of it is laid out again.
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

/** The distance between the picture and the edge of the frame (px). */
const MARGIN = 16;

interface Sight {
  /** Brings things into the frame: all of them for null, which then stay in it whatever becomes of its size. */
  show: (ids: ReadonlySet<string> | null) => void;
  /** Moves the picture if a thing is out of the frame. */
  ensureInSight: (id: string) => void;
  /** Somebody looks at a part of it by hand. */
  leave: () => void;
}

/** What of the picture is seen. */
export function useSight(frame: RefObject<HTMLElement | null>, fit: FitViewOptions<VertexNode>): Sight {
  const flow = useReactFlow<VertexNode>();
  const whole = useRef(true);
  const show = useCallback(
    (ids: ReadonlySet<string> | null) => {
      whole.current = ids === null;
      void flow.fitView(ids === null ? fit : { ...fit, nodes: [...ids].map((id) => ({ id })) });
    },
    [flow, fit],
  );
  const leave = useCallback(() => {
    whole.current = false;
  }, []);
  const ensureInSight = useCallback(
    (id: string) => {
      const node = flow.getNode(id);
      const box = frame.current?.getBoundingClientRect();
      if (node === undefined || box === undefined) return;
      const { width = 0, height = 0, position } = node;
      const first = flow.flowToScreenPosition(position);
      const last = flow.flowToScreenPosition({ x: position.x + width, y: position.y + height });
      const inside =
        first.x >= box.left + MARGIN &&
        first.y >= box.top + MARGIN &&
        last.x <= box.right - MARGIN &&
        last.y <= box.bottom - MARGIN;
      if (inside) return;
      leave();
      void flow.setCenter(position.x + width / 2, position.y + height / 2, { zoom: flow.getZoom() });
    },
    [flow, frame, leave],
  );
  useEffect(() => {
    if (frame.current === null) return;
    const observer = new ResizeObserver(() => {
      // React Flow has to have learnt of the new size first.
      requestAnimationFrame(() => whole.current && show(null));
    });
    observer.observe(frame.current);
    return () => observer.disconnect();
  }, [frame, show]);
  return { show, ensureInSight, leave };
}
