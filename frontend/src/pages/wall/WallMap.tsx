import { useId } from "react";
import { useDocked } from "../../fleet/robot";
import { SceneCanvas } from "../../scene/SceneCanvas";
import { useSurroundings } from "../../scene/SceneCard";
import { describeScene } from "../../scene/words";
import { useScene, useServices } from "../../store/context";
import { RobotScope } from "../robot/RobotPage";
import classes from "./wall.module.css";

/** The map of the only robot there is, large; nothing before its pose is known. */
export function WallMap({ robot }: { robot: string }) {
  return (
    <RobotScope key={robot} robot={robot}>
      <Picture />
    </RobotScope>
  );
}

async function leave(): Promise<void> {}

function Picture() {
  const { scene } = useServices();
  const around = useSurroundings();
  const docked = useDocked();
  const words = useScene((scene) => (scene === null ? "" : describeScene(scene, docked)));
  const wordsId = useId();
  if (words === "") return null;
  return (
    <div className={classes.map} data-testid="wall-map">
      <SceneCanvas
        scene={scene}
        around={around}
        placeable={false}
        wall
        describedBy={wordsId}
        onPlace={leave}
        onGhost={leave}
      />
      <span id={wordsId} hidden>
        {words}
      </span>
    </div>
  );
}
