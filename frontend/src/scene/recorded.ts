import type { Pose, PoseEvent, Scene } from "@dock-gateway/client";
import type { GoalReplay } from "../api/goals";
import { between, distance, type Point, place } from "../store/geometry";
import { JUMP_M, Trail, trailOf } from "../store/sceneBuffer";
import { Surroundings } from "../store/surroundings";
import { lastUpTo } from "../ui/crosshair";
import type { SceneSource } from "./painter";

/** Between poses farther apart the robot stood still: only those that differ are stored (s). */
const MAX_GLIDE_S = 1;

/** What was recorded longer before a moment says nothing of it (s). */
const OLD_S = 2;

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

/** What the laser saw at a moment of a goal, as its recording has it. */
export class RecordedSurroundings extends Surroundings {
  #points: readonly Point[] = [];

  /** @param recorded What the replay shows of the recording. */
  constructor(private readonly recorded: GoalReplay) {
    super();
  }

  /** Goes to a moment of the goal (s); to its end for null. */
  seek(moment: number | null): void {
    const scan = at(this.recorded.scans, moment);
    this.#points = scan === null ? [] : scan.points.map(([x = 0, y = 0]) => ({ x, y }));
  }

  override scanIn(_: Scene, robot: Pose): readonly Point[] {
    return this.#points.map((point) => place(robot, point));
  }
}

/** What was last recorded at a moment (s); of the end for null, null where nothing is near. */
export function at<Each extends { at: number }>(
  recorded: readonly Each[],
  moment: number | null,
): Each | null {
  const last = recorded.length - 1;
  const index = moment === null ? last : lastUpTo(moment, recorded.length, (each) => recorded[each]?.at ?? 0);
  const found = recorded[index] ?? null;
  return found === null || (moment !== null && moment - found.at > OLD_S) ? null : found;
}
