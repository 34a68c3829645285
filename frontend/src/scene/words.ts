import type { Pose, Scene } from "@dock-gateway/client";
import { distance, toDegrees } from "../store/geometry";
import { fixed } from "../ui/numbers";
import { shapesOf } from "./shapes";

/** `x −1.50 m, y 0.40 m, heading 17°`. */
export function describePose({ x, y, theta }: Pose): string {
  return `x ${fixed(x, 2)} m, y ${fixed(y, 2)} m, heading ${fixed(toDegrees(theta), 0)}°`;
}

/**
 * The picture in words.
 *
 * @param docked What the gateway says, as every page shows it; null where that is unknown.
 */
export function describeScene(scene: Scene, docked: boolean | null): string {
  const { robot } = scene;
  const where = `Robot at ${describePose(robot)}`;
  const frame = scene.frame === "odom" ? " in odometry’s frame, which drifts" : "";
  return `${where}${frame}. ${describeDocking(scene, robot, docked)}`;
}

function describeDocking(scene: Scene, robot: Pose, docked: boolean | null): string {
  if (docked === true) return "Docked.";
  const goal = shapesOf(scene).docked;
  const away = goal === null ? null : `${fixed(distance(robot, goal), 2)} m`;
  if (docked === false) return away === null ? "Not docked." : `Not docked: ${away} to go.`;
  return away === null ? "Position of the dock unknown." : `${away} from its place on the dock.`;
}
