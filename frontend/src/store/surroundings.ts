import type { GatewayEvent, Points, Pose, RobotMap, Scene } from "@dock-gateway/client";
import { compose, inverse, type Point, place } from "./geometry";

/** A scan that is older is not where the laser looks now (ms). */
const SCAN_MS = 1500;
const ORIGIN: Pose = { x: 0, y: 0, theta: 0 };
const NOTHING: readonly Point[] = [];

/** What is around a robot, as it comes: its map (without the cells), what its laser sees, and its path. */
export class Surroundings {
  map: RobotMap | null = null;
  scan: Points | null = null;
  path: Points | null = null;
  #scannedAt = Number.NEGATIVE_INFINITY;
  readonly #listeners = new Set<() => void>();

  /** @param now On the clock of the callers (ms). */
  push(event: GatewayEvent, now: number): void {
    if (event.type === "map") {
      if (JSON.stringify(event.map) === JSON.stringify(this.map)) return;
      this.map = event.map;
    } else if (event.type === "scan") {
      this.scan = event.scan;
      this.#scannedAt = now;
    } else if (event.type === "path") {
      if (JSON.stringify(event.path) === JSON.stringify(this.path)) return;
      this.path = event.path;
    } else return;
    for (const listener of this.#listeners) listener();
  }

  /** The points that the laser sees, in the frame of a scene. */
  scanIn(scene: Scene, robot: Pose, now: number): readonly Point[] {
    return now - this.#scannedAt > SCAN_MS ? NOTHING : this.#points(this.scan, scene, robot);
  }

  pathIn(scene: Scene, robot: Pose): readonly Point[] {
    return this.#points(this.path, scene, robot);
  }

  #points(points: Points | null, scene: Scene, robot: Pose): readonly Point[] {
    if (points === null || points.frame === null) return NOTHING;
    const frame = points.frame === "base_link" ? robot : this.frameIn(scene, points.frame);
    if (frame === null) return NOTHING;
    return points.points.map(([x = 0, y = 0]) => place(frame, { x, y }));
  }

  /** Where a frame lies in that of a scene; null where the two are not related. */
  frameIn(scene: Scene, frame: string): Pose | null {
    return frameIn(scene, this.map, frame);
  }

  /** Calls `listener` for every event that says something new, until the returned function is called. */
  subscribe(listener: () => void): () => void {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }
}

/** Where a frame lies in that of a scene: `odom`, `map`, which may have another name, or `world`. */
export function frameIn(scene: Scene, map: RobotMap | null, frame: string): Pose | null {
  if (frame === scene.frame) return ORIGIN;
  const odom = scene.odom ?? null;
  if (frame === "odom" || odom === null) return odom;
  if (frame !== "map" && frame !== map?.map?.frame) return null;
  const inMap = map?.odom ?? null;
  return inMap === null ? null : compose(odom, inverse(inMap));
}
