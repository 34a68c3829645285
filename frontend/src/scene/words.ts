import type { Pose, Scene } from "@dock-gateway/client";
import { distance, normalizeAngle, toDegrees } from "../store/geometry";
import { fixed } from "../ui/numbers";
import { CONTACT_RADIUS_M, shapesOf } from "./shapes";

const CONTACT_ANGLE_RAD = (5 * Math.PI) / 180;

/** `x −1.50 m, y 0.40 m, heading 17°`. */
export function describePose({ x, y, theta }: Pose): string {
  return `x ${fixed(x, 2)} m, y ${fixed(y, 2)} m, heading ${fixed(toDegrees(theta), 0)}°`;
}

/**
 * The picture in words.
 *
 * @param docked What the simulator says, where there is one.
 */
export function describeScene(scene: Scene, docked: boolean | null): string {
  const { robot } = scene;
  const where = `Robot at ${describePose(robot)}`;
  const frame = scene.frame === "odom" ? " in odometry’s frame, which drifts" : "";
  return `${where}${frame}. ${describeDocking(scene, robot, docked)}`;
}

function describeDocking(scene: Scene, robot: Pose, told: boolean | null): string {
  const goal = shapesOf(scene).docked;
  if (goal === null)
    return told === null ? "Position of the dock unknown." : told ? "Docked." : "Not docked.";
  const away = distance(robot, goal);
  const turned = Math.abs(normalizeAngle(robot.theta - goal.theta));
  const docked = told ?? (away <= CONTACT_RADIUS_M && turned <= CONTACT_ANGLE_RAD);
  return docked ? "Docked." : `Not docked: ${fixed(away, 2)} m to go.`;
}
