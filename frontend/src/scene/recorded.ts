import type { PoseEvent, Scene } from "@dock-gateway/client";
import { between, distance } from "../store/geometry";
import { JUMP_M, Trail, trailOf } from "../store/sceneBuffer";
import { lastUpTo } from "../ui/crosshair";
import type { SceneSource } from "./painter";

/** Between poses farther apart the robot stood still: only those that differ are stored (s). */
const MAX_GLIDE_S = 1;

interface Recorded {
  /** In seconds since the goal began. */
  at: number;
  scene: Scene;
}

/** The stored poses of a goal, as they were at one of its moments. */
export class RecordedScene implements SceneSource {
  latest: Scene | null = null;
  trail = new Trail();
  readonly #poses: readonly Recorded[];
  readonly #listeners = new Set<() => void>();

  /** @param began When the goal began (ms). */
  constructor(poses: readonly PoseEvent[], began: number) {
    this.#poses = poses.map(({ time, scene }) => ({ at: (Date.parse(time) - began) / 1000, scene }));
    this.seek(null);
  }

  /** Goes to a moment of the goal (s); to its end for null. */
  seek(moment: number | null): void {
    const poses = this.#poses;
    const found =
      moment === null ? poses.length - 1 : lastUpTo(moment, poses.length, (index) => poses[index]?.at ?? 0);
    const index = Math.max(0, found);
    const [before, after] = [poses[index], poses[index + 1]];
    if (before === undefined) return;
    const robot =
      moment === null || after === undefined ? before.scene.robot : robotBetween(before, after, moment);
    this.latest = { ...before.scene, robot };
    this.trail = trailOf(poses.slice(0, index + 1).map(({ scene }) => scene));
    this.trail.push(robot);
    for (const listener of this.#listeners) listener();
  }

  robotAt(): Scene["robot"] | null {
    return this.latest?.robot ?? null;
  }

  detectionsAt(): [] {
    return [];
  }

  changesAt(): boolean {
    return false;
  }

  subscribe(listener: () => void): () => void {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }
}

function robotBetween(before: Recorded, after: Recorded, moment: number): Scene["robot"] {
  const [from, to] = [before.scene.robot, after.scene.robot];
  const took = after.at - before.at;
  const carried = before.scene.frame !== after.scene.frame || distance(from, to) > JUMP_M;
  if (carried || took > MAX_GLIDE_S || moment <= before.at) return from;
  return between(from, to, (moment - before.at) / took);
}
