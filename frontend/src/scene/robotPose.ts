import type { GatewayEvent, Pose, Scene } from "@dock-gateway/client";
import { compose, inverse } from "../store/geometry";
import { openStream, streamUrl } from "../stream/stream";
import { degrees, type PoseDraft } from "./poseDraft";

/** How long a robot's pose, and a map that it is in, are waited for, in ms. */
const POSE_MS = 4000;
const MAP_MS = 1000;

/** What is known of a robot's map, where there are maps. */
interface Located {
  map: { frame: string } | null;
  /** Where the robot's odometry begins in the map. */
  odom: Pose | null;
}

/** Where a robot stands now; null where that is not known. */
export function robotPose(robot: string): Promise<PoseDraft | null> {
  return new Promise((resolve) => {
    let scene: Scene | null = null;
    let located: Located | null = null;
    const end = () => {
      clearTimeout(timer);
      close();
      resolve(scene === null ? null : placeIn(scene, located));
    };
    let timer = setTimeout(end, POSE_MS);
    const onEvent = (event: GatewayEvent) => {
      const { type, map } = event as { type: string; map?: Located };
      if (type === "map" && map !== undefined) located = map;
      if (event.type === "scene" && scene === null) {
        clearTimeout(timer);
        timer = setTimeout(end, MAP_MS);
      }
      if (event.type === "scene") scene = event.scene;
      if (scene !== null && located?.odom != null) end();
    };
    const url = streamUrl(window.location, { include: "scene,map", feedback: "false", robot });
    const close = openStream(url, { onEvent, onConnection: () => undefined });
  });
}

/** A robot's pose in its map as it is typed; that in a simulated world where there is no map; null for neither. */
export function placeIn(scene: Scene, located: Located | null): PoseDraft | null {
  const start = scene.frame === "odom" ? { x: 0, y: 0, theta: 0 } : scene.odom;
  if (located?.odom != null && start !== null)
    return rounded(compose(located.odom, compose(inverse(start), scene.robot)), located.map?.frame ?? "map");
  return scene.frame === "world" ? rounded(scene.robot, "map") : null;
}

function rounded({ x, y, theta }: Pose, frame: string): PoseDraft {
  const metres = (value: number) => Math.round(value * 1000) / 1000;
  return { x: metres(x), y: metres(y), heading: degrees(theta), frame };
}
