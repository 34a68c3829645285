import { useComputedColorScheme } from "@mantine/core";
import { useElementSize, useReducedMotion } from "@mantine/hooks";
import { useEffect, useRef, useState } from "react";
import { watchSight } from "../ui/sight";
import { Tool } from "../ui/Tool";
import { SCENE_COLORS } from "./colors";
import { keepScale, keptScale } from "./following";
import type { Pose } from "./geometry";
import { Gestures } from "./gestures";
import { MapTools } from "./MapTools";
import { Painter, type SceneSource } from "./painter";
import classes from "./scene.module.css";

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
  const scheme = useComputedColorScheme("light");
  const reducedMotion = useReducedMotion();
  const { ref: boxRef, width, height } = useElementSize<HTMLDivElement>();
  const canvasRef = useRef<HTMLCanvasElement>(null);
  const painterRef = useRef<Painter | null>(null);
  const [following, setFollowing] = useState(() => keptScale() !== null);
  const handlers = useRef({ onPlace, onGhost });
  const latest = useRef({ width, height, placeable });
  handlers.current = { onPlace, onGhost };
  latest.current = { width, height, placeable };

  useEffect(() => {
    const canvas = canvasRef.current;
    if (canvas === null) return;
    const painter = new Painter(canvas, scene, SCENE_COLORS[scheme], reducedMotion, painterRef.current);
    if (painterRef.current === null) painter.follow(keptScale());
    painter.onFollow = (scale) => {
      keepScale(scale);
      setFollowing(scale !== null);
    };
    painter.resize(latest.current);
    painter.handle = latest.current.placeable;
    const place = (pose: Pose) => {
      handlers.current.onPlace(pose).finally(() => {
        if (painter.ghost === pose) painter.showGhost(null);
      });
    };
    const gestures = new Gestures(canvas, painter, place, (pose) => handlers.current.onGhost(pose));
    painterRef.current = painter;
    const watched = watchSight(canvas, (inSight) => {
      painter.inSight = inSight;
    });
    return () => {
      watched();
      gestures.destroy();
      painter.destroy();
    };
  }, [scene, scheme, reducedMotion]);

  useEffect(() => painterRef.current?.resize({ width, height }), [width, height]);
  useEffect(() => {
    if (painterRef.current !== null) painterRef.current.handle = placeable;
  }, [placeable]);

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
        onZoom={(factor) => painterRef.current?.zoomBy(factor)}
        onShowAll={() => painterRef.current?.showAll()}
      >
        <Tool
          name="Follow the robot"
          pressed={following}
          onClick={() => (following ? painterRef.current?.showAll() : painterRef.current?.follow())}
        >
          <path d="M11 2h2v3.07A7 7 0 0 1 18.93 11H22v2h-3.07A7 7 0 0 1 13 18.93V22h-2v-3.07A7 7 0 0 1 5.07 13H2v-2h3.07A7 7 0 0 1 11 5.07V2Zm1 5a5 5 0 1 0 0 10 5 5 0 0 0 0-10Zm0 3a2 2 0 1 1 0 4 2 2 0 0 1 0-4Z" />
        </Tool>
      </MapTools>
    </div>
  );
}
