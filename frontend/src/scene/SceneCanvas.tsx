import type { Pose } from "@dock-gateway/client";
import { type ReactNode, useCallback, useEffect, useRef, useState } from "react";
import { Tool } from "../ui/Tool";
import { Camera } from "./camera";
import { Gestures } from "./gestures";
import { Painter, type SceneSource } from "./painter";
import { type Means, usePicture } from "./picture";
import classes from "./scene.module.css";
import { keepScale, keptScale } from "./view";

interface SceneCanvasProps {
  scene: SceneSource;
  /** Whether the robot can be dragged. */
  placeable: boolean;
  /** The id of the picture in words. */
  describedBy: string;
  /** Called where the robot was put somewhere; the picture shows it there until the promise is settled. */
  onPlace: (pose: Pose) => Promise<void>;
  /** Called where the keyboard moves the robot that is about to be placed; null where it was given up. */
  onGhost: (pose: Pose | null) => void;
}

/** The robot and its dock from above. Draws outside of React. */
export function SceneCanvas({ scene, placeable, describedBy, onPlace, onGhost }: SceneCanvasProps) {
  const [following, setFollowing] = useState(() => keptScale() !== null);
  const handlers = useRef({ onPlace, onGhost, placeable });
  handlers.current = { onPlace, onGhost, placeable };
  const [camera] = useState(() => {
    const created = new Camera();
    created.follow(keptScale());
    created.onFollow = (scale) => {
      keepScale(scale);
      setFollowing(scale !== null);
    };
    return created;
  });
  const create = useCallback(
    ({ canvas, colors, reducedMotion }: Means) => {
      const picture = new Painter(canvas, camera, scene, colors, reducedMotion);
      picture.handle = handlers.current.placeable;
      const place = (pose: Pose) => {
        handlers.current.onPlace(pose).finally(() => {
          if (picture.ghost === pose) picture.showGhost(null);
        });
      };
      return {
        picture,
        gestures: new Gestures(canvas, picture, place, (pose) => handlers.current.onGhost(pose)),
      };
    },
    [camera, scene],
  );
  const { boxRef, canvasRef, pictureRef } = usePicture(create);
  useEffect(() => {
    if (pictureRef.current !== null) pictureRef.current.handle = placeable;
  }, [pictureRef, placeable]);

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
      <MapTools
        onZoom={(factor) => pictureRef.current?.zoomBy(factor)}
        onShowAll={() => pictureRef.current?.showAll()}
      >
        <Tool
          name="Follow the robot"
          pressed={following}
          onClick={() => (following ? pictureRef.current?.showAll() : pictureRef.current?.follow())}
          path="M11 2h2v3.07A7 7 0 0 1 18.93 11H22v2h-3.07A7 7 0 0 1 13 18.93V22h-2v-3.07A7 7 0 0 1 5.07 13H2v-2h3.07A7 7 0 0 1 11 5.07V2Zm1 5a5 5 0 1 0 0 10 5 5 0 0 0 0-10Zm0 3a2 2 0 1 1 0 4 2 2 0 0 1 0-4Z"
        />
      </MapTools>
    </div>
  );
}

const ZOOM_STEP = 1.4;

interface MapToolsProps {
  onZoom: (factor: number) => void;
  onShowAll: () => void;
  /** Before the last one. */
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
