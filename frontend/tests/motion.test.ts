import type { PoseEvent } from "@dock-gateway/client";
import { describe, expect, it } from "vitest";
import { knowsDock, MotionSource, motionOf } from "../src/goals/motion";
import { emptyScene, START } from "./events";

/** The robot at `x`, looking at a dock at 0, some seconds after the goal began. */
function pose(seconds: number, x: number, dock: typeof emptyScene.dock = emptyScene.dock): PoseEvent {
  return {
    type: "pose",
    id: `${seconds}`,
    time: new Date(START + seconds * 1000).toISOString(),
    goal_id: "a",
    action_name: "/dock",
    scene: { ...emptyScene, dock, robot: { x, y: 0, theta: 0 } },
  };
}

/** Ten poses a second, at a velocity from a place on. */
const drive = (from: number, until: number, x: number, velocity: number) =>
  Array.from({ length: Math.round((until - from) * 10) + 1 }, (_, index) =>
    pose(from + index / 10, x + (velocity * index) / 10),
  );

describe("the motion of a goal", () => {
  it("has the distance to the docked pose, and the velocity", () => {
    const { times, distances, velocities } = motionOf(drive(0, 2, -2, 0.5), START, START + 2000);
    expect(times).toHaveLength(21);
    expect(distances[0]).toBeCloseTo(1.8);
    expect(distances.at(-1)).toBeCloseTo(0.8);
    for (const velocity of velocities.slice(1)) expect(velocity).toBeCloseTo(0.5);
  });

  it("is negative backwards", () => {
    const { velocities } = motionOf(drive(0, 1, -0.2, -0.1), START, START + 1000);
    expect(velocities.at(-1)).toBeCloseTo(-0.1);
  });

  it("stands still where no pose is stored, until the goal has ended", () => {
    const poses = [...drive(0, 1, -2, 0.5), ...drive(6, 7, -1.5, 0.5)];
    const { times, velocities } = motionOf(poses, START, START + 20_000);
    const at = (seconds: number) => velocities[times.findIndex((time) => time >= seconds - 0.01)];
    expect(at(5.9)).toBeCloseTo(0);
    expect(at(6.5)).toBeCloseTo(0.5);
    expect(at(19.9)).toBeCloseTo(0);
    expect(times).toEqual([...times].sort((one, other) => one - other));
  });

  it("has no velocity where the robot was carried, and none before two poses are known", () => {
    const { velocities } = motionOf([pose(0, -2), pose(0.1, -1), pose(0.2, -0.99)], START, START + 200);
    expect(velocities[0]).toBe(0);
    expect(velocities[1]).toBeNull();
    expect(velocities[2]).toBeCloseTo(0.1);
    expect(motionOf([], START, START + 9000).times).toEqual([]);
  });

  it("is plotted without the distance where the dock is not known", () => {
    const lost = motionOf([pose(0, -2, null), pose(0.1, -1.9, null)], START, START + 100);
    expect(knowsDock(lost.distances)).toBe(false);
    expect(new MotionSource(lost).read()).toHaveLength(2);
    const known = motionOf([pose(0, -2), pose(0.1, -1.9)], START, START + 100);
    expect(new MotionSource(known).read()).toHaveLength(3);
  });
});
