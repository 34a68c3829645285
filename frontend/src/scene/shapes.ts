import { compose, type Point, type Pose } from "./geometry";

/** The robot is a disc around base_link, its camera and its receivers at the front (m). */
export const ROBOT_RADIUS_M = 0.15;

/** The dock's box, in the marker's frame (m): its front carries the contacts, the marker is set back above it. */
export const DOCK_BOX = { front: -0.04, back: 0.16, half: 0.15 };

/** base_link of a docked robot, in the marker's frame: what nav2's docking has by default. */
const DOCKED_IN_MARKER: Pose = { x: -0.2, y: 0, theta: 0 };

/** So close to the docked pose the robot touches the contacts (m). */
export const CONTACT_RADIUS_M = 0.02;

/** The infrared receivers: where they look, in rad from straight ahead, and how wide they see. */
export const RECEIVERS = {
  left: (20 * Math.PI) / 180,
  center: 0,
  right: (-20 * Math.PI) / 180,
} as const;
export const RECEIVER_FIELD_RAD = 0.5;
/** How far a beam is drawn that sees nothing (m). */
export const UNSEEN_BEAM_M = 0.25;

/** What is drawn of a scene, in the frame of the scene. */
export interface Shapes {
  /** The marker on the face of the dock, where that is known. */
  dock: Pose | null;
  docked: Pose | null;
  staging: Pose | null;
}

interface Known {
  dock: Pose | null;
  docked?: Pose | null | undefined;
  staging: Pose | null;
}

/** Where the dock and the poses around it are, as far as that is known. */
export function shapesOf(scene: Known): Shapes {
  const docked = scene.docked ?? (scene.dock === null ? null : compose(scene.dock, DOCKED_IN_MARKER));
  return { dock: scene.dock, docked, staging: scene.staging };
}

/** What a fitted view has to show. */
export function pointsOf(robot: Pose, { dock, docked, staging }: Shapes): Point[] {
  return [robot, dock, docked, staging].filter((point) => point !== null);
}
