import type { Pose, PoseEvent, Scene } from "@dock-gateway/client";
import { isSame } from "../clock/same";
import { between, distance, type Point } from "./geometry";

/** A detection of the marker can be seen for this long. */
export const FADE_MS = 1500;
const MAX_DETECTIONS = 48;
/** The way between two events takes as long as they were apart, but no longer than this. */
const MAX_GLIDE_MS = 200;

export interface Detection {
  pose: Pose;
  /** When it came (ms). */
  at: number;
}

/**
 * The scene as it comes and as it is drawn: between two events the robot glides from one pose to the next, one event
 * late. Times are those of one clock (ms) that the callers choose.
 */
export class SceneBuffer {
  latest: Scene | null = null;
  /** When the latest came (ms). */
  arrivedAt = Number.NEGATIVE_INFINITY;
  readonly trail = new Trail();
  /** When the first came, in the gateway's time (ms). */
  #beganAt = Number.POSITIVE_INFINITY;
  #recalled: readonly PoseEvent[] = [];
  #detections: Detection[] = [];
  #from: Pose | null = null;
  #glideMs = 0;
  readonly #listeners = new Set<() => void>();

  /** @param time When it was so, in the gateway's time (ms). */
  push(scene: Scene, now: number, time = now): void {
    const shown = this.robotAt(now);
    const before = this.latest;
    const moved = before !== null && before.frame !== scene.frame;
    if (moved) {
      this.trail.clear();
      this.#detections = [];
    }
    const target = scene.robot;
    const carried = shown === null || moved || distance(shown, target) > JUMP_M;
    this.#from = carried ? target : shown;
    this.#glideMs = carried ? 0 : Math.min(MAX_GLIDE_MS, now - this.arrivedAt);
    this.latest = scene;
    this.arrivedAt = now;
    this.trail.push(target);
    if (before === null) {
      this.#beganAt = time;
      this.recall(this.#recalled);
    }
    if (scene.marker !== null && !samePose(scene.marker, before?.marker ?? null)) {
      this.#detections = [...this.#detections, { pose: scene.marker, at: now }].slice(-MAX_DETECTIONS);
    }
    // One that says the same once more, as of a robot that stands still, changes no picture.
    if (shown !== null && samePose(shown, target) && isSame(scene, before)) return;
    for (const listener of this.#listeners) listener();
  }

  /** Begins the trail with where the robot was before the first scene came: stored poses, oldest first. */
  recall(poses: readonly PoseEvent[]): void {
    this.#recalled = poses;
    const before = poses.filter(({ time }) => Date.parse(time) < this.#beganAt).map(({ scene }) => scene);
    if (this.latest === null || before.at(-1)?.frame !== this.latest.frame) return;
    this.trail.precede(trailOf(before).points);
    for (const listener of this.#listeners) listener();
  }

  /** The robot as it is to be drawn now. */
  robotAt(now: number): Pose | null {
    const target = this.latest?.robot ?? null;
    if (target === null || this.#from === null || this.#glideMs <= 0) return target;
    return between(this.#from, target, Math.min(1, Math.max(0, (now - this.arrivedAt) / this.#glideMs)));
  }

  /** The detections that can still be seen, oldest first. */
  detectionsAt(now: number): readonly Detection[] {
    return this.#detections.filter((detection) => now - detection.at < FADE_MS);
  }

  /** Whether the picture changes by itself, without another event. */
  changesAt(now: number): boolean {
    const last = this.#detections.at(-1);
    const fading = last !== undefined && now - last.at < FADE_MS;
    return fading || this.#glides(now);
  }

  #glides(now: number): boolean {
    if (now - this.arrivedAt > this.#glideMs || this.#from === null) return false;
    const target = this.latest?.robot ?? null;
    return target !== null && !samePose(this.#from, target);
  }

  /** Calls `listener` for every event that says something new, until the returned function is called. */
  subscribe(listener: () => void): () => void {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }
}

function samePose(a: Pose, b: Pose | null): boolean {
  return b !== null && a.x === b.x && a.y === b.y && a.theta === b.theta;
}

/** Points closer together than this become one. */
const SPACING_M = 0.015;
/** A robot that moves farther at once was carried: a new trail begins. */
export const JUMP_M = 0.4;
export const MAX_POINTS = 2000;

/** Where the robot has been, oldest first; bounded. */
export class Trail {
  #points: Point[] = [];

  get points(): readonly Point[] {
    return this.#points;
  }

  /** Adds where the robot is now. */
  push({ x, y }: Point): void {
    const last = this.#points.at(-1);
    if (last !== undefined) {
      const moved = distance(last, { x, y });
      if (moved < SPACING_M) return;
      if (moved > JUMP_M) this.clear();
    }
    this.#points.push({ x, y });
    // In batches: moving the array for every point is not for free.
    if (this.#points.length >= MAX_POINTS + 200) this.#points = this.#points.slice(-MAX_POINTS);
  }

  /** Puts where the robot was before in front. */
  precede(earlier: readonly Point[]): void {
    const later = this.#points;
    this.clear();
    for (const point of [...earlier, ...later]) this.push(point);
  }

  clear(): void {
    this.#points = [];
  }
}

/** The way through scenes, oldest first; it starts again where the frame is another. */
export function trailOf(scenes: readonly Scene[]): Trail {
  const trail = new Trail();
  for (const [index, { frame, robot }] of scenes.entries()) {
    if (index > 0 && scenes[index - 1]?.frame !== frame) trail.clear();
    trail.push(robot);
  }
  return trail;
}
