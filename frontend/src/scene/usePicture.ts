import { useComputedColorScheme } from "@mantine/core";
import { useElementSize, useReducedMotion } from "@mantine/hooks";
import { type RefCallback, type RefObject, useEffect, useRef } from "react";
import { watchSight } from "../ui/sight";
import { SCENE_COLORS, type SceneColors } from "./colors";
import type { Gestures } from "./gestures";
import type { Picture } from "./picture";

/** What a picture is drawn with. */
export interface Means {
  canvas: HTMLCanvasElement;
  colors: SceneColors;
  reducedMotion: boolean;
}

export interface DrawnPicture<P extends Picture> {
  boxRef: RefCallback<HTMLDivElement | null>;
  canvasRef: RefObject<HTMLCanvasElement | null>;
  /** Null before it is drawn for the first time. */
  pictureRef: RefObject<P | null>;
}

/**
 * A picture on a canvas that fills its box, drawn outside of React.
 *
 * @param create Called again where the colors or the wish for less motion change, or it is another function itself.
 */
export function usePicture<P extends Picture>(
  create: (means: Means) => { picture: P; gestures: Gestures },
): DrawnPicture<P> {
  const scheme = useComputedColorScheme("light");
  const reducedMotion = useReducedMotion();
  const { ref: boxRef, width, height } = useElementSize<HTMLDivElement>();
  const canvasRef = useRef<HTMLCanvasElement>(null);
  const pictureRef = useRef<P>(null);
  const size = useRef({ width, height });
  size.current = { width, height };

  useEffect(() => {
    const canvas = canvasRef.current;
    if (canvas === null) return;
    const { picture, gestures } = create({ canvas, colors: SCENE_COLORS[scheme], reducedMotion });
    pictureRef.current = picture;
    picture.resize(size.current);
    const unwatch = watchSight(canvas, (inSight) => {
      picture.inSight = inSight;
    });
    return () => {
      unwatch();
      gestures.destroy();
      picture.destroy();
    };
  }, [create, scheme, reducedMotion]);

  useEffect(() => pictureRef.current?.resize({ width, height }), [width, height]);
  return { boxRef, canvasRef, pictureRef };
}
