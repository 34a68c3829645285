import type { PoseEvent } from "@dock-gateway/client";
import { describe, expect, it, vi } from "vitest";
import { RecordedScene } from "../src/scene/recorded";
import { at, emptyScene, START } from "./events";

/** The robot `x` metres ahead, some seconds after the goal began. */
function pose(seconds: number, x: number, frame: "odom" | "world" = "odom"): PoseEvent {
  return {
    type: "pose",
    id: `${seconds}`,
    time: at(seconds),
    goal_id: "a",
    action_name: "/dock",
    scene: { ...emptyScene, frame, robot: { x, y: 0, theta: 0 } },
  };
}

describe("a recorded scene", () => {
  const xs = (scene: RecordedScene) => scene.trail.points.map(({ x }) => x);

  it("is at any moment where the robot was, with its way until then", () => {
    const scene = new RecordedScene([pose(1, 0), pose(1.5, 0.1), pose(2, 0.2), pose(20, 0.3)], START);
    expect([scene.robotAt()?.x, xs(scene)]).toEqual([0.3, [0, 0.1, 0.2, 0.3]]);
    const heard = vi.fn();
    const forget = scene.subscribe(heard);
    scene.seek(1.25);
    expect(scene.robotAt()?.x).toBeCloseTo(0.05);
    expect(xs(scene)).toHaveLength(2);
    scene.seek(0);
    expect([scene.robotAt()?.x, xs(scene)]).toEqual([0, [0]]);
    scene.seek(19);
    expect(scene.robotAt()?.x, "it stood still").toBe(0.2);
    forget();
    scene.seek(null);
    expect(heard).toHaveBeenCalledTimes(3);
    expect([scene.changesAt(), scene.detectionsAt()]).toEqual([false, []]);
  });

  it("has the footprint that was stored", () => {
    const footprint = { radius: 0.3, points: null };
    const last = pose(2, 0.2);
    const scene = new RecordedScene([pose(1, 0), { ...last, scene: { ...last.scene, footprint } }], START);
    expect(scene.latest?.footprint).toEqual(footprint);
    scene.seek(1.5);
    expect(scene.latest?.footprint).toBeNull();
  });

  it("begins its trail anew where the robot was carried or the frame is another", () => {
    const scene = new RecordedScene([pose(1, 0), pose(1.2, 5), pose(1.4, 5.1, "world")], START);
    scene.seek(1.1);
    expect(scene.robotAt()?.x).toBe(0);
    scene.seek(1.3);
    expect([scene.robotAt()?.x, xs(scene)]).toEqual([5, [5]]);
    scene.seek(null);
    expect([scene.latest?.frame, xs(scene)]).toEqual(["world", [5.1]]);
  });

  it("has nothing where nothing was stored", () => {
    const scene = new RecordedScene([], START);
    expect([scene.latest, scene.robotAt(), xs(scene)]).toEqual([null, null, []]);
  });
});
