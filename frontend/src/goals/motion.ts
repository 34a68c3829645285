import type { PoseEvent } from "@dock-gateway/client";
import { shapesOf } from "../scene/shapes";
import { distance } from "../store/geometry";
import { JUMP_M } from "../store/sceneBuffer";
import type { PlotSource } from "../ui/plotData";

/** Between poses farther apart the robot stood still: only those that differ are stored (s). */
const STANDING_S = 1;
/** It stood from this long after the pose before until this long before the next one (s). */
const EDGE_S = 0.1;
/** A velocity is measured over this long (s): from one pose to the next their noise is as large as the way. */
const OVER_S = 0.25;

/** How a goal's robot moved, by the time since the goal began (s), ascending. */
export interface Motion {
  times: number[];
  /** To where it stands when it is docked (m); null where the dock is not known. */
  distances: (number | null)[];
  /** Forward (m/s); null where it was carried. */
  velocities: (number | null)[];
}

interface Sample {
  at: number;
  robot: PoseEvent["scene"]["robot"];
  away: number | null;
}

/**
 * The motion in a goal's stored poses.
 *
 * @param began When the goal began (ms).
 * @param ended When it ended (ms).
 */
export function motionOf(poses: readonly PoseEvent[], began: number, ended: number): Motion {
  const samples = samplesOf(poses, began, ended);
  return {
    times: samples.map(({ at }) => at),
    distances: samples.map(({ away }) => away),
    velocities: velocitiesOf(samples),
  };
}

/** The poses, and where the robot stood still, the beginning and the end of that. */
function samplesOf(poses: readonly PoseEvent[], began: number, ended: number): Sample[] {
  const samples: Sample[] = [];
  const standUntil = (end: number) => {
    const last = samples.at(-1);
    if (last === undefined || end - last.at <= STANDING_S) return;
    samples.push({ ...last, at: last.at + EDGE_S }, { ...last, at: end - EDGE_S });
  };
  for (const { time, scene } of poses) {
    const at = (Date.parse(time) - began) / 1000;
    const { docked } = shapesOf(scene);
    standUntil(at);
    samples.push({ at, robot: scene.robot, away: docked === null ? null : distance(scene.robot, docked) });
  }
  standUntil((ended - began) / 1000);
  return samples;
}

function velocitiesOf(samples: readonly Sample[]): (number | null)[] {
  let from = 0;
  return samples.map((now, index) => {
    const before = samples[index - 1];
    if (before === undefined) return 0;
    if (distance(before.robot, now.robot) > JUMP_M) from = index;
    while (from + 1 < index && now.at - (samples[from + 1]?.at ?? 0) >= OVER_S) from += 1;
    const start = samples[from] ?? before;
    const took = now.at - start.at;
    return from === index || took <= 0 ? null : forward(start.robot, now.robot) / took;
  });
}

/** How far one pose is before another, in the direction in which the robot looks. */
function forward(from: Sample["robot"], to: Sample["robot"]): number {
  return (to.x - from.x) * Math.cos(from.theta) + (to.y - from.y) * Math.sin(from.theta);
}

/** The motion of a goal that has ended, to be plotted: the distance to the dock where that is known, and the velocity. */
export class MotionSource implements PlotSource {
  readonly version = 1;
  readonly #columns: [number[], ...(number | null)[][]];

  constructor({ times, distances, velocities }: Motion) {
    this.#columns = knowsDock(distances) ? [times, distances, velocities] : [times, velocities];
  }

  read(): [number[], ...(number | null)[][]] {
    return this.#columns;
  }
}

/** Whether it was known where the dock is. */
export function knowsDock(distances: Motion["distances"]): boolean {
  return distances.some((away) => away !== null);
}
