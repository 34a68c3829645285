import type { Footprint, Pose } from "@dock-gateway/client";
import { compose, type Point } from "../store/geometry";

/** The footprint of a robot that publishes none. */
const DEFAULT_FOOTPRINT: Footprint = { radius: 0.15, points: null };
/** The heading arrow is at least this share of the robot, also where base_link is near its edge. */
const MIN_ARROW = 1 / 3;

/** The robot's outline around base_link. */
export function footprintOf(scene: { footprint?: Footprint | null } | null): Footprint {
  return scene?.footprint ?? DEFAULT_FOOTPRINT;
}

/** The radius of the circle that the heading arrow fills: the one within the footprint (m). */
export function arrowRadius({ radius, points }: Footprint): number {
  if (points === null) return radius;
  const distances = points.map((point, index) => edgeDistance(point, points.at(index - 1) ?? point));
  return Math.max(Math.min(...distances), MIN_ARROW * radius);
}

/** The distance between base_link and an edge (m). */
function edgeDistance(from: Point, to: Point): number {
  const [dx, dy] = [to.x - from.x, to.y - from.y];
  const share = -(from.x * dx + from.y * dy) / (dx * dx + dy * dy || 1);
  const part = Math.min(1, Math.max(0, share));
  return Math.hypot(from.x + part * dx, from.y + part * dy);
}

/** The dock's box, in the marker's frame (m): its front carries the contacts, the marker is set back above it. */
export const DOCK_BOX = { front: -0.04, back: 0.16, half: 0.15 };

/** base_link of a docked robot, in the marker's frame: what nav2's docking has by default. */
export const DOCKED_IN_MARKER: Pose = { x: -0.2, y: 0, theta: 0 };

/** So close to the docked pose the robot touches the contacts (m). */
export const CONTACT_RADIUS_M = 0.02;

/** The infrared receivers: where they look, in rad from straight ahead, and how wide they see. */
export const RECEIVERS = {
  left: (20 * Math.PI) / 180,
  center: 0,
  right: (-20 * Math.PI) / 180,
} as const;
/** Their place ahead of base_link (m). */
export const RECEIVER_X_M = 0.15;
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

/** The known poses of the dock and around it. */
export function shapesOf(scene: Known): Shapes {
  const docked = scene.docked ?? (scene.dock === null ? null : compose(scene.dock, DOCKED_IN_MARKER));
  return { dock: scene.dock, docked, staging: scene.staging };
}

/** What a fitted view has to show. */
export function pointsOf(robot: Pose, { dock, docked, staging }: Shapes, footprint: Footprint): Point[] {
  const poses = [robot, docked, staging].filter((pose) => pose !== null);
  const corners = poses.flatMap((pose) => around(pose, footprint));
  return dock === null ? corners : [...corners, dock];
}

/** What a fitted view has to show of a robot: its margin has room for one that is not larger than most. */
export function around({ x, y }: Point, { radius }: Footprint): Point[] {
  const beyond = Math.max(0, radius - DEFAULT_FOOTPRINT.radius);
  return [
    { x: x - beyond, y: y - beyond },
    { x: x + beyond, y: y + beyond },
  ];
}
