import type { Pose } from "@dock-gateway/client";

/** A pose as it is typed: in metres and degrees, in a frame. */
export interface PoseDraft {
  x: number | string;
  y: number | string;
  heading: number | string;
  frame: string;
}

export type PoseErrors = Partial<Record<keyof PoseDraft, string>>;

/** An empty one where there is no pose. */
export function poseDraft(pose: (Pose & { frame: string }) | null): PoseDraft {
  if (pose === null) return { x: "", y: "", heading: 0, frame: "map" };
  return { x: pose.x, y: pose.y, heading: degrees(pose.theta), frame: pose.frame };
}

export function degrees(angle: number): number {
  return Math.round((angle * 180_000) / Math.PI) / 1000;
}

/** What is wrong with each field. */
export function poseErrors({ x, y, heading, frame }: PoseDraft): PoseErrors {
  const errors: PoseErrors = {};
  if (typeof x !== "number" || Math.abs(x) > 1e6) errors.x = "A number of metres";
  if (typeof y !== "number" || Math.abs(y) > 1e6) errors.y = "A number of metres";
  if (typeof heading !== "number" || Math.abs(heading) > 360) errors.heading = "From -360° to 360°";
  if (frame.trim() === "") errors.frame = "The name of a frame";
  return errors;
}

/** The pose of a draft without errors. */
export function poseOf({ x, y, heading, frame }: PoseDraft): Pose & { frame: string } {
  return { x: Number(x), y: Number(y), theta: (Number(heading) * Math.PI) / 180, frame: frame.trim() };
}

/** `x 1.5 m, y -2 m, 90°` */
export function poseWords({ x, y, theta, frame }: Pose & { frame: string }): string {
  const turned = theta === 0 ? "" : `, ${Math.round(degrees(theta))}°`;
  return `x ${shortened(x)} m, y ${shortened(y)} m${turned}${frame === "map" ? "" : ` in ${frame}`}`;
}

function shortened(metres: number): number {
  return Math.round(metres * 100) / 100;
}
