import type { Pose } from "@dock-gateway/client";
import { type ReactNode, useCallback, useEffect, useRef, useState, useSyncExternalStore } from "react";
import { distance, type Point, place } from "../store/geometry";
import { groundIn, type SceneLayer } from "../store/layers";
import { Tool } from "../ui/Tool";
import { useLatest } from "../ui/useLatest";
import { Around, type NamedDock, type Surroundings } from "./around";
import { Camera } from "./camera";
import { Gestures } from "./gestures";
import { Painter, type SceneSource } from "./painter";
import { type Means, usePicture } from "./picture";
import classes from "./scene.module.css";
import { DOCK_BOX } from "./shapes";
import { keepScale, keptScale, toScreen } from "./view";

interface SceneCanvasProps {
  scene: SceneSource;
  /** Whether the robot can be dragged. */
  placeable: boolean;
  /** The id of the picture in words. */
  describedBy: string;
  /** Called where the robot was put somewhere; the picture shows it there until the promise is settled. */
  onPlace: (pose: Pose) => Promise<void>;
  /** What is around the robot; nothing of it without. */
  around?: Surroundings | undefined;
  /** Called where a place was pressed. */
  onPick?: ((pick: Pick) => void) | undefined;
  /** Called where the keyboard moves the robot that is about to be placed; null where it was given up. */
  onGhost: (pose: Pose | null) => void;
  /** Only to be looked at, from a distance: the whole map, without buttons. */
  wall?: boolean;
  /** What is shown on top of the picture, such as a menu. */
  children?: ReactNode;
}

/** A place that was pressed. */
export interface Pick {
  /** On the canvas (CSS pixels). */
  at: Point;
  /** In the frame of the scene. */
  point: Point;
  /** The docks there; of a place without one, none. */
  dock: NamedDock | null;
}

/** The robot and its dock from above. Draws outside of React. */
export function SceneCanvas(props: SceneCanvasProps) {
  const { scene, placeable, describedBy, around, wall = false, onPlace, onGhost, onPick } = props;
  const [following, setFollowing] = useState(() => keptScale() !== null);
  const handlers = useLatest({ onPlace, onGhost, onPick, placeable, around });
  const layers = around?.layers ?? NO_LAYERS;
  const hasGround = useHasGround(scene, layers);
  const [camera] = useState(() => {
    const created = new Camera();
    if (wall) return created;
    created.follow(keptScale());
    created.onFollow = (scale) => {
      keepScale(scale);
      setFollowing(scale !== null);
    };
    return created;
  });
  const aroundRef = useRef<Around | null>(null);
  const create = useCallback(
    ({ canvas, colors, scheme, reducedMotion }: Means) => {
      const { around } = handlers.current;
      const seen = around === undefined ? null : new Around({ ...around, layers }, scheme);
      const picture = new Painter(canvas, camera, scene, colors, reducedMotion, seen);
      aroundRef.current = seen;
      if (seen !== null) seen.whole = wall;
      picture.handle = handlers.current.placeable;
      const put = (pose: Pose) => {
        handlers.current.onPlace(pose).finally(() => {
          if (picture.ghost === pose) picture.showGhost(null);
        });
      };
      return {
        picture,
        gestures: new Gestures(
          canvas,
          picture,
          put,
          (pose) => handlers.current.onGhost(pose),
          handlers.current.onPick === undefined
            ? null
            : (at) =>
                handlers.current.onPick?.({ at, point: picture.toWorld(at), dock: dockAt(picture, at) }),
        ),
      };
    },
    [camera, scene, layers, wall],
  );
  const { boxRef, canvasRef, pictureRef } = usePicture(create);
  useEffect(() => {
    if (pictureRef.current !== null) pictureRef.current.handle = placeable;
  }, [pictureRef, placeable]);

  useEffect(() => {
    if (around !== undefined) aroundRef.current?.know(around);
  }, [around]);

  return (
    <div className={classes.frame} ref={boxRef}>
      {/* biome-ignore lint/a11y/noInteractiveElementToNoninteractiveRole: an application takes keys, a canvas alone says nothing */}
      <canvas
        ref={canvasRef}
        className={classes.canvas}
        role="application"
        aria-label="Picture of the robot and its dock from above"
        aria-describedby={describedBy}
        tabIndex={0}
        data-testid="scene"
      />
      {onPick !== undefined && <div className={classes.middle} aria-hidden="true" />}
      {props.children}
      {!wall && (
        <MapTools
          onZoom={(factor) => pictureRef.current?.zoomBy(factor)}
          onShowAll={() => pictureRef.current?.showAll()}
        >
          {hasGround && <WholeMapTool onClick={() => pictureRef.current?.showGround()} />}
          <Tool
            name="Follow the robot"
            pressed={following}
            onClick={() => (following ? pictureRef.current?.showAll() : pictureRef.current?.follow())}
            path="M11 2h2v3.07A7 7 0 0 1 18.93 11H22v2h-3.07A7 7 0 0 1 13 18.93V22h-2v-3.07A7 7 0 0 1 5.07 13H2v-2h3.07A7 7 0 0 1 11 5.07V2Zm1 5a5 5 0 1 0 0 10 5 5 0 0 0 0-10Zm0 3a2 2 0 1 1 0 4 2 2 0 0 1 0-4Z"
          />
        </MapTools>
      )}
    </div>
  );
}

const NO_LAYERS: readonly SceneLayer[] = [];

/** Whether there is a ground that can be related to where the robot is. */
function useHasGround(scene: SceneSource, layers: readonly SceneLayer[]): boolean {
  return useSyncExternalStore(
    useCallback(
      (listener) => {
        const forget = [scene, ...layers].map((source) => source.subscribe(listener));
        return () => {
          for (const each of forget) each();
        };
      },
      [scene, layers],
    ),
    () => scene.latest !== null && groundIn(scene.latest, layers) !== null,
  );
}

/** So near a dock is meant, in CSS pixels. */
const REACH_PX = 22;

function dockAt(picture: Painter, at: Point): NamedDock | null {
  const { view, size, seen } = picture;
  const near = seen.docks.map((dock) => ({ dock, away: distance(toScreen(view, size, middleOf(dock)), at) }));
  const reach = Math.max(REACH_PX, 0.2 * view.scale);
  return near.filter(({ away }) => away <= reach).sort((a, b) => a.away - b.away)[0]?.dock ?? null;
}

/** The middle of the box of a dock, behind its face. */
function middleOf({ pose }: NamedDock): Point {
  return place(pose, { x: (DOCK_BOX.front + DOCK_BOX.back) / 2, y: 0 });
}

const ZOOM_STEP = 1.4;

interface MapToolsProps {
  onZoom: (factor: number) => void;
  onShowAll: () => void;
  /** Further buttons, before *Show all*. */
  children?: ReactNode;
}

/** The buttons in the corner of a map. */
export function MapTools({ onZoom, onShowAll, children }: MapToolsProps) {
  return (
    <div className={classes.tools}>
      <Tool name="Closer" onClick={() => onZoom(ZOOM_STEP)} path="M11 5h2v6h6v2h-6v6h-2v-6H5v-2h6V5Z" />
      <Tool name="Farther" onClick={() => onZoom(1 / ZOOM_STEP)} path="M5 11h14v2H5v-2Z" />
      {children}
      <Tool
        name="Show all"
        onClick={onShowAll}
        path="M4 4h6v2H6v4H4V4Zm10 0h6v6h-2V6h-4V4ZM4 14h2v4h4v2H4v-6Zm14 0h2v6h-6v-2h4v-4Z"
      />
    </div>
  );
}

/** Shows all of a map. */
export function WholeMapTool({ onClick }: { onClick: () => void }) {
  return (
    <Tool
      name="Whole map"
      onClick={onClick}
      path="m3 5.5 6-2.2 6 2.2 6-2.2v15.2l-6 2.2-6-2.2-6 2.2V5.5Zm5 .3-3 1.1v11l3-1.1v-11Zm2 0v11l4 1.4v-11l-4-1.4Zm6 1.4v11l3-1.1v-11l-3 1.1Z"
    />
  );
}
