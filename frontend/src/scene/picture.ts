import { useComputedColorScheme } from "@mantine/core";
import { useElementSize, useReducedMotion } from "@mantine/hooks";
import { type RefCallback, type RefObject, useEffect, useRef } from "react";
import type { Point, Size, View } from "../store/geometry";
import type { Scheme } from "../store/layers";
import { watchSight } from "../ui/sight";
import { SCENE_COLORS, type SceneColors } from "../ui/tokens";
import { useLatest } from "../ui/useLatest";
import type { Camera } from "./camera";
import type { Gestures } from "./gestures";

/** A picture of the ground on a canvas, as its camera sees it. */
export abstract class Picture {
  /** Nothing is drawn while the canvas is out of sight. */
  #inSight = true;

  constructor(protected readonly camera: Camera) {}

  /** Draws in the next frame. */
  abstract readonly invalidate: () => void;

  /** The points that the view shows by default. */
  protected abstract points(): Point[];

  abstract destroy(): void;

  get size(): Size {
    return this.camera.size;
  }

  get view(): View {
    return this.camera.view;
  }

  get inSight(): boolean {
    return this.#inSight;
  }

  set inSight(inSight: boolean) {
    this.#inSight = inSight;
    if (inSight) this.invalidate();
  }

  resize(size: Size): void {
    if (this.camera.resize(size)) this.invalidate();
  }

  /** Closer by `factor` around a place on the canvas, its middle by default. */
  zoomBy(factor: number, place?: Point): void {
    this.camera.zoomBy(factor, place);
    this.invalidate();
  }

  panBy(dx: number, dy: number): void {
    this.camera.panBy(dx, dy);
    this.invalidate();
  }

  /** Back to the view that shows everything. */
  showAll(): void {
    this.camera.showAll(this.points());
    this.invalidate();
  }

  toWorld(place: Point): Point {
    return this.camera.toWorld(place);
  }
}

/** What a picture is drawn with. */
export interface Means {
  canvas: HTMLCanvasElement;
  colors: SceneColors;
  scheme: Scheme;
  reducedMotion: boolean;
}

interface DrawnPicture<P extends Picture> {
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
  const size = useLatest({ width, height });

  useEffect(() => {
    const canvas = canvasRef.current;
    if (canvas === null) return;
    const { picture, gestures } = create({
      canvas,
      colors: SCENE_COLORS[scheme],
      scheme,
      reducedMotion,
    });
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
