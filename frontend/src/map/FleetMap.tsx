import { useComputedColorScheme } from "@mantine/core";
import { useElementSize, useReducedMotion } from "@mantine/hooks";
import { memo, useEffect, useRef } from "react";
import { Link } from "react-router";
import { useNaming } from "../fleet/useNaming";
import { robotPath } from "../robot/path";
import { SCENE_COLORS } from "../scene/colors";
import { Gestures } from "../scene/gestures";
import { MapTools } from "../scene/MapTools";
import { watchSight } from "../ui/sight";
import type { FleetScenes } from "./fleetScenes";
import classes from "./map.module.css";
import type { Mark, Placed } from "./placement";
import { FleetStage } from "./stage";

/** The robots from above, each a link to its page. Moved outside of React. */
export function FleetMap({ scenes, placed }: { scenes: FleetScenes; placed: readonly Placed[] }) {
  const scheme = useComputedColorScheme("light");
  const reducedMotion = useReducedMotion();
  const naming = useNaming();
  const { ref: boxRef, width, height } = useElementSize<HTMLDivElement>();
  const canvasRef = useRef<HTMLCanvasElement>(null);
  const stageRef = useRef<FleetStage | null>(null);
  const elements = useRef(new Map<string, HTMLElement>());
  const size = useRef({ width, height });
  size.current = { width, height };

  useEffect(() => {
    const canvas = canvasRef.current;
    if (canvas === null) return;
    const colors = SCENE_COLORS[scheme];
    const stage = new FleetStage(canvas, elements.current, scenes, colors, reducedMotion, stageRef.current);
    stage.resize(size.current);
    stageRef.current = stage;
    const gestures = new Gestures(canvas, stage);
    const watched = watchSight(canvas, (inSight) => {
      stage.inSight = inSight;
    });
    return () => {
      watched();
      gestures.destroy();
      stage.destroy();
    };
  }, [scenes, scheme, reducedMotion]);

  useEffect(() => stageRef.current?.resize({ width, height }), [width, height]);
  // Those that are new are put in their places.
  // biome-ignore lint/correctness/useExhaustiveDependencies: what is placed is read by the stage from the page
  useEffect(() => stageRef.current?.invalidate(), [placed]);

  return (
    <div className={classes.frame} ref={boxRef}>
      {/* biome-ignore lint/a11y/noInteractiveElementToNoninteractiveRole: an application takes keys, a canvas alone says nothing */}
      <canvas
        ref={canvasRef}
        className={classes.canvas}
        role="application"
        aria-label="Ground and docks from above. Arrows move the map, + and − zoom, 0 shows all."
        tabIndex={0}
        data-testid="fleet-map"
      />
      <ul
        className={classes.robots}
        aria-label="Robots on the map"
        onFocus={({ target }) => {
          if (isOutside(target, canvasRef.current)) stageRef.current?.showAll();
        }}
      >
        {placed.map(({ robot: { name }, mark }) => (
          <Marker
            key={name}
            robot={name}
            name={naming.nameOf(name)}
            level={mark?.level}
            words={mark?.words}
            elements={elements.current}
          />
        ))}
      </ul>
      <MapTools
        onZoom={(factor) => stageRef.current?.zoomBy(factor)}
        onShowAll={() => stageRef.current?.showAll()}
      />
    </div>
  );
}

/** Whether none of an element is within another one, as where the map was moved away from a robot. */
function isOutside(element: Element, frame: Element | null): boolean {
  if (frame === null) return false;
  const [one, other] = [element.getBoundingClientRect(), frame.getBoundingClientRect()];
  return one.right < other.left || one.left > other.right || one.bottom < other.top || one.top > other.bottom;
}

interface MarkerProps {
  robot: string;
  name: string;
  level: Mark["level"] | undefined;
  words: string | undefined;
  elements: Map<string, HTMLElement>;
}

const Marker = memo(function Marker({ robot, name, level, words, elements }: MarkerProps) {
  return (
    <li
      className={classes.robot}
      data-level={level}
      data-testid={`on map ${robot}`}
      ref={(element) => {
        if (element === null) return;
        elements.set(robot, element);
        return () => void elements.delete(robot);
      }}
    >
      <Link to={robotPath(robot)} className={classes.link ?? ""}>
        <svg className={classes.disc} viewBox="-10 -10 20 20" aria-hidden="true">
          <circle r="9.4" />
          <path d="M6.8 0-3.9 4.7-1.5 0-3.9-4.7Z" />
        </svg>
        <span className={classes.label}>
          {name}
          {words !== undefined && <span className={classes.words}>{words}</span>}
        </span>
      </Link>
    </li>
  );
});
