import { memo, useCallback, useEffect, useRef, useState, useSyncExternalStore } from "react";
import { Link } from "react-router";
import { useNaming } from "../../fleet/context";
import { robotPath } from "../../fleet/names";
import { Camera } from "../../scene/camera";
import { Gestures } from "../../scene/gestures";
import { type Means, usePicture } from "../../scene/picture";
import { MapTools, WholeMapTool } from "../../scene/SceneCanvas";
import type { Mark, Placed } from "./MapPage";
import classes from "./map.module.css";
import type { FleetScenes } from "./scenes";
import { FleetStage, INSET_PX } from "./stage";

/** The robots from above, each a link to its page. Moved outside of React. */
export function FleetMap({ scenes, placed }: { scenes: FleetScenes; placed: readonly Placed[] }) {
  const naming = useNaming();
  const hasGround = useSyncExternalStore(scenes.subscribe, () => scenes.hasGround);
  const elements = useRef(new Map<string, HTMLElement>());
  const [camera] = useState(() => new Camera(INSET_PX));
  const create = useCallback(
    (means: Means) => {
      const { canvas } = means;
      const picture = new FleetStage(means, camera, elements.current, scenes);
      return { picture, gestures: new Gestures(canvas, picture) };
    },
    [camera, scenes],
  );
  const { boxRef, canvasRef, pictureRef } = usePicture(create);
  // Those that are new are put in their places.
  // biome-ignore lint/correctness/useExhaustiveDependencies: what is placed is read by the stage from the page
  useEffect(() => pictureRef.current?.invalidate(), [pictureRef, placed]);

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
          if (isOutside(target, canvasRef.current)) pictureRef.current?.showAll();
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
        onZoom={(factor) => pictureRef.current?.zoomBy(factor)}
        onShowAll={() => pictureRef.current?.showAll()}
      >
        {hasGround && <WholeMapTool onClick={() => pictureRef.current?.showGround()} />}
      </MapTools>
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
          <rect x="-10" y="-10" width="20" height="20" />
          <path d="M6.8 0-3.9 4.7-1.5 0-3.9-4.7Z" />
        </svg>
        <span className={classes.label} data-label>
          {name}
          {words !== undefined && <span className={classes.words}>{words}</span>}
        </span>
      </Link>
    </li>
  );
});
