import type { Pose } from "@dock-gateway/client";

export interface Point {
  x: number;
  y: number;
}

/** What part of the plane is seen: the point in the middle, and CSS pixels a metre. */
export interface View extends Point {
  scale: number;
}

/** The size of a canvas, in CSS pixels. */
export interface Size {
  width: number;
  height: number;
}

/** Returns the angle between −π and π with the same direction. */
export function normalizeAngle(angle: number): number {
  const turn = 2 * Math.PI;
  return angle - turn * Math.round(angle / turn);
}

/** `inner`, given in the frame of `outer`, in the frame that `outer` is given in. */
export function compose(outer: Pose, inner: Pose): Pose {
  const cos = Math.cos(outer.theta);
  const sin = Math.sin(outer.theta);
  return {
    x: outer.x + cos * inner.x - sin * inner.y,
    y: outer.y + sin * inner.x + cos * inner.y,
    theta: normalizeAngle(outer.theta + inner.theta),
  };
}

/** Where the frame that `pose` is given in lies in the frame of `pose`. */
export function inverse({ x, y, theta }: Pose): Pose {
  const cos = Math.cos(theta);
  const sin = Math.sin(theta);
  return { x: -cos * x - sin * y, y: sin * x - cos * y, theta: -theta };
}

/** A point that is given in the frame of `pose`, in the frame that `pose` is given in. */
export function place({ x, y, theta }: Pose, point: Point): Point {
  const cos = Math.cos(theta);
  const sin = Math.sin(theta);
  return { x: x + cos * point.x - sin * point.y, y: y + sin * point.x + cos * point.y };
}

export function distance(from: Point, to: Point): number {
  return Math.hypot(to.x - from.x, to.y - from.y);
}

/** Between two poses, turning the short way; `share` is 0 at `from` and 1 at `to`. */
export function between(from: Pose, to: Pose, share: number): Pose {
  return {
    x: from.x + (to.x - from.x) * share,
    y: from.y + (to.y - from.y) * share,
    theta: normalizeAngle(from.theta + normalizeAngle(to.theta - from.theta) * share),
  };
}

export function toDegrees(radians: number): number {
  return (radians * 180) / Math.PI;
}

export function toRadians(degrees: number): number {
  return (degrees * Math.PI) / 180;
}
