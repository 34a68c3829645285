// @vitest-environment jsdom

import type { Pose, PoseEvent } from "@dock-gateway/client";
import { describe, expect, it, vi } from "vitest";
import { arrowRadius, footprintOf, pointsOf, shapesOf } from "../src/scene/shapes";
import {
  fitTo,
  follow,
  formatLength,
  gridStep,
  keepScale,
  keptScale,
  MAX_SCALE,
  pan,
  toScreen,
  toWorld,
  zoom,
} from "../src/scene/view";
import { describePose, describeScene } from "../src/scene/words";
import { between, compose, normalizeAngle, toRadians } from "../src/store/geometry";
import { FADE_MS, JUMP_M, MAX_POINTS, SceneBuffer, Trail } from "../src/store/sceneBuffer";
import { emptyScene } from "./events";

const size = { width: 600, height: 400 };
const origin: Pose = { x: 0, y: 0, theta: 0 };

describe("poses", () => {
  it("turn the short way", () => {
    expect(normalizeAngle(3.5 * Math.PI)).toBeCloseTo(-Math.PI / 2);
    const from = { x: 0, y: 0, theta: toRadians(170) };
    const to = { x: 2, y: 0, theta: toRadians(-170) };
    const half = between(from, to, 0.5);
    expect(half.x).toBe(1);
    expect(Math.abs(half.theta)).toBeCloseTo(Math.PI);
  });

  it("are given in each other's frames", () => {
    const pose = compose({ x: 1, y: 2, theta: Math.PI / 2 }, { x: 1, y: 0.5, theta: 0.1 });
    expect(pose.x).toBeCloseTo(0.5);
    expect(pose.y).toBeCloseTo(3);
    expect(pose.theta).toBeCloseTo(Math.PI / 2 + 0.1);
  });
});

describe("the view", () => {
  const view = { x: 1, y: -1, scale: 100 };

  it("has x to the right and y up, and knows the way back", () => {
    expect(toScreen(view, size, { x: 1, y: -1 })).toEqual({ x: 300, y: 200 });
    expect(toScreen(view, size, { x: 2, y: 0 })).toEqual({ x: 400, y: 100 });
    expect(toWorld(view, size, { x: 400, y: 100 })).toEqual({ x: 2, y: 0 });
  });

  it("keeps what is under the pointer when it zooms, within bounds", () => {
    const place = { x: 120, y: 330 };
    const before = toWorld(view, size, place);
    const after = toWorld(zoom(view, size, place, 2), size, place);
    expect(after.x).toBeCloseTo(before.x);
    expect(after.y).toBeCloseTo(before.y);
    expect(zoom(view, size, place, 1e6).scale).toBe(MAX_SCALE);
  });

  it("moves along with the pointer", () => {
    const point = toWorld(view, size, { x: 100, y: 100 });
    const place = toScreen(pan(view, 30, -20), size, point);
    expect(place.x).toBeCloseTo(130);
    expect(place.y).toBeCloseTo(80);
  });

  it("fits everything with space around it", () => {
    const points = [
      { x: -3, y: 2 },
      { x: 1, y: -1 },
    ];
    const fitted = fitTo(points, size);
    for (const point of points) {
      const { x, y } = toScreen(fitted, size, point);
      expect(x).toBeGreaterThan(20);
      expect(x).toBeLessThan(size.width - 20);
      expect(y).toBeGreaterThan(20);
      expect(y).toBeLessThan(size.height - 20);
    }
  });

  it("stays while a robot drives in it, follows one that leaves, closes in on one that came back", () => {
    const start = fitTo([{ x: -2, y: 0 }, origin], size);
    expect(follow(start, [{ x: -1, y: 0.2 }, origin], size)).toBe(start);
    const left = follow(start, [{ x: -4, y: 0 }, origin], size);
    expect(left.scale).toBeLessThan(start.scale);
    const far = { x: -10, y: 0, scale: 20 };
    expect(follow(far, [{ x: -1, y: 0 }, origin], size).scale).toBeGreaterThan(100);
  });

  it("has a grid of round steps, said in the unit that suits them", () => {
    expect(gridStep(100, 44)).toBeCloseTo(0.5);
    expect(gridStep(44, 44)).toBeCloseTo(1);
    expect(gridStep(10, 44)).toBeCloseTo(5);
    expect(gridStep(1000, 44)).toBeCloseTo(0.05);
    expect([formatLength(0.5), formatLength(2)]).toEqual(["50 cm", "2 m"]);
  });
});

describe("the trail", () => {
  it("leaves out what does not move", () => {
    const trail = new Trail();
    for (let step = 0; step < 100; step += 1) trail.push({ x: step * 0.001, y: 0 });
    expect(trail.points.length).toBeLessThan(10);
    expect(trail.points.length).toBeGreaterThan(4);
  });

  it("begins anew where the robot was carried", () => {
    const trail = new Trail();
    trail.push({ x: 0, y: 0 });
    trail.push({ x: 0.1, y: 0 });
    trail.push({ x: 0.2 + JUMP_M, y: 0 });
    expect(trail.points).toEqual([{ x: 0.2 + JUMP_M, y: 0 }]);
  });

  it("is bounded, and keeps the newest", () => {
    const trail = new Trail();
    for (let step = 0; step < 3 * MAX_POINTS; step += 1) trail.push({ x: step * 0.02, y: 0 });
    expect(trail.points.length).toBeLessThanOrEqual(MAX_POINTS + 200);
    expect(trail.points.at(-1)?.x).toBeCloseTo((3 * MAX_POINTS - 1) * 0.02);
  });
});

describe("the scene", () => {
  const at = (x: number, change = {}) => ({ ...emptyScene, robot: { x, y: 0, theta: 0 }, ...change });

  it("glides from one pose to the next, and has then arrived", () => {
    const buffer = new SceneBuffer();
    buffer.push(at(0), 1000);
    buffer.push(at(0.1), 1050);
    expect(buffer.robotAt(1050)?.x).toBe(0);
    expect(buffer.robotAt(1075)?.x).toBeCloseTo(0.05);
    expect(buffer.robotAt(1100)?.x).toBeCloseTo(0.1);
    expect(buffer.robotAt(9000)?.x).toBeCloseTo(0.1);
  });

  it("goes on from where it is drawn when the next pose comes early", () => {
    const buffer = new SceneBuffer();
    buffer.push(at(0), 1000);
    buffer.push(at(0.1), 1100);
    buffer.push(at(0.2), 1150);
    expect(buffer.robotAt(1150)?.x).toBeCloseTo(0.05);
    expect(buffer.robotAt(1200)?.x).toBeCloseTo(0.2);
  });

  it("does not glide where the robot was carried or the frame is another", () => {
    const buffer = new SceneBuffer();
    buffer.push(at(0), 1000);
    buffer.push(at(2), 1050);
    expect(buffer.robotAt(1050)?.x).toBe(2);
    buffer.push(at(2.1, { frame: "odom" }), 1100);
    expect(buffer.robotAt(1100)?.x).toBeCloseTo(2.1);
    expect(buffer.trail.points).toHaveLength(1);
  });

  it("changes by itself only while something glides or fades", () => {
    const buffer = new SceneBuffer();
    expect(buffer.changesAt(0)).toBe(false);
    buffer.push(at(0), 1000);
    expect(buffer.changesAt(1001)).toBe(false);
    buffer.push(at(0.1), 1050);
    expect(buffer.changesAt(1060)).toBe(true);
    expect(buffer.changesAt(1200)).toBe(false);
    buffer.push(at(0.1, { marker: origin }), 1250);
    expect(buffer.changesAt(1250 + FADE_MS - 1)).toBe(true);
    expect(buffer.changesAt(1250 + FADE_MS + 1)).toBe(false);
  });

  it("keeps detections until they have faded, each once", () => {
    const buffer = new SceneBuffer();
    buffer.push(at(0, { marker: origin }), 1000);
    buffer.push(at(0, { marker: { ...origin } }), 1050);
    buffer.push(at(0, { marker: { x: 0.01, y: 0, theta: 0 } }), 1100);
    expect(buffer.detectionsAt(1100)).toHaveLength(2);
    expect(buffer.detectionsAt(1000 + FADE_MS + 50)).toHaveLength(1);
    expect(buffer.detectionsAt(1100 + FADE_MS + 50)).toHaveLength(0);
  });

  describe("with the stored poses of a goal that ran before", () => {
    const pose = (time: number, x: number, change = {}): PoseEvent => ({
      type: "pose",
      id: `${time}`,
      time: new Date(time).toISOString(),
      goal_id: "a",
      action_name: "/dock",
      scene: at(x, change),
    });
    const stored = [pose(900, -0.2), pose(950, -0.1), pose(1000, 0), pose(1050, 0.1)];
    const xs = (buffer: SceneBuffer) => buffer.trail.points.map(({ x }) => x);

    it("begins its trail with those from before the first scene, whichever comes first", () => {
      const [early, late] = [new SceneBuffer(), new SceneBuffer()];
      early.recall(stored);
      for (const buffer of [early, late]) {
        buffer.push(at(0), 7, 1000);
        buffer.push(at(0.1), 57, 1050);
      }
      const listener = vi.fn();
      late.subscribe(listener);
      late.recall(stored);
      expect(xs(early)).toEqual([-0.2, -0.1, 0, 0.1]);
      expect(xs(late)).toEqual(xs(early));
      expect(listener).toHaveBeenCalledTimes(1);
    });

    it("leaves out what was in another frame, and what was before the robot was carried", () => {
      const buffer = new SceneBuffer();
      buffer.push(at(0), 7, 1000);
      buffer.recall([pose(850, -0.3, { frame: "odom" }), ...stored]);
      expect(xs(buffer)).toEqual([-0.2, -0.1, 0]);
      const carried = new SceneBuffer();
      carried.push(at(5), 7, 1000);
      carried.recall(stored);
      expect(xs(carried)).toEqual([5]);
      const odometry = new SceneBuffer();
      odometry.push(at(0, { frame: "odom" }), 7, 1000);
      odometry.recall(stored);
      expect(xs(odometry)).toEqual([0]);
    });
  });

  it("tells nobody when nothing is new, and knows when it came all the same", () => {
    const buffer = new SceneBuffer();
    const listener = vi.fn();
    buffer.subscribe(listener);
    for (let now = 1000; now < 5000; now += 50) buffer.push(at(0), now);
    expect(listener).toHaveBeenCalledTimes(1);
    expect(buffer.arrivedAt).toBe(4950);
    buffer.push(at(0, { staging: origin }), 5000);
    expect(listener).toHaveBeenCalledTimes(2);
  });

  it("tells those who listen, until they do not", () => {
    const buffer = new SceneBuffer();
    const listener = vi.fn();
    const unsubscribe = buffer.subscribe(listener);
    buffer.push(at(0), 1000);
    unsubscribe();
    buffer.push(at(0.1), 1050);
    expect(listener).toHaveBeenCalledTimes(1);
  });
});

describe("the scale of followed robots", () => {
  it("is kept in this browser, and what is not one is not", () => {
    expect(keptScale()).toBeNull();
    keepScale(250);
    expect(keptScale()).toBe(250);
    keepScale(null);
    expect(keptScale()).toBeNull();
    for (const text of ["NaN", "far", "1e9", "0"]) {
      localStorage.setItem("dock-gateway-map-follow", text);
      expect(keptScale()).toBeNull();
    }
    localStorage.clear();
  });

  it("is not kept where storage is blocked", () => {
    const blocked = () => {
      throw new Error("blocked");
    };
    vi.stubGlobal("localStorage", { getItem: blocked, setItem: blocked, removeItem: blocked });
    keepScale(250);
    expect(keptScale()).toBeNull();
    vi.unstubAllGlobals();
  });
});

describe("the dock", () => {
  const staging = { x: -0.9, y: 0, theta: 0 };

  it("has a docked pose before it, nav2's where nobody says another", () => {
    expect(shapesOf(emptyScene).docked).toEqual({ x: -0.2, y: 0, theta: 0 });
    expect(shapesOf({ ...emptyScene, docked: { x: 1, y: 1, theta: 1 } }).docked).toEqual({
      x: 1,
      y: 1,
      theta: 1,
    });
    expect(shapesOf({ ...emptyScene, dock: null })).toEqual({ dock: null, docked: null, staging: null });
  });

  it("is in a fitted view with the robot and the staging pose", () => {
    const points = pointsOf(emptyScene.robot, shapesOf({ ...emptyScene, staging }), footprintOf(emptyScene));
    expect(points).toContainEqual({ x: staging.x, y: staging.y });
    expect(points).toContainEqual(emptyScene.dock);
  });
});

describe("a footprint", () => {
  const corner = { x: 0.4, y: 0.3 };
  const points = [corner, { x: 0.4, y: -0.3 }, { x: -0.4, y: -0.3 }, { x: -0.4, y: 0.3 }];
  const rectangle = { radius: 0.5, points };

  it("is round where none is published, as with poses that were stored without", () => {
    expect(footprintOf(emptyScene)).toEqual({ radius: 0.15, points: null });
    expect(footprintOf(null)).toEqual(footprintOf({}));
    expect(footprintOf({ footprint: rectangle })).toBe(rectangle);
  });

  it("has room for an arrow, also at an edge", () => {
    expect(arrowRadius({ radius: 0.2, points: null })).toBe(0.2);
    expect(arrowRadius(rectangle)).toBeCloseTo(0.3);
    const ahead = points.map(({ x, y }) => ({ x: x + 0.4, y }));
    expect(arrowRadius({ radius: 0.9, points: ahead })).toBeCloseTo(0.3);
    expect(arrowRadius({ radius: 0.9, points: [corner, corner, { x: 0.9, y: 0 }] })).toBeGreaterThan(0.3);
  });

  it("fits in the view", () => {
    const large = pointsOf(
      origin,
      { dock: null, docked: null, staging: null },
      { radius: 1.15, points: null },
    );
    expect(large.map(({ x, y }) => [x, y].map(Math.round))).toEqual([
      [-1, -1],
      [1, 1],
    ]);
    expect(fitTo(large, size).scale).toBeLessThan(size.height / (2 * 1.15));
  });
});

describe("the picture in words", () => {
  it("says where the robot is, with signs that can be read", () => {
    expect(describePose({ x: -1.5, y: 0.4, theta: toRadians(-17) })).toBe(
      "x −1.50 m, y 0.40 m, heading −17°",
    );
    expect(describePose({ x: -0.001, y: 0, theta: -0.001 })).toBe("x 0.00 m, y 0.00 m, heading 0°");
  });

  it("says how far it is to the dock, and docked only where the gateway says so", () => {
    expect(describeScene(emptyScene, null)).toMatch(/\. 1\.36 m from its place on the dock\.$/);
    expect(describeScene(emptyScene, false)).toMatch(/Not docked: 1\.36 m to go\.$/);
    expect(describeScene(emptyScene, true)).toMatch(/ Docked\.$/);
    const docked = { ...emptyScene, robot: { x: -0.2, y: 0, theta: 0 } };
    expect(describeScene(docked, false)).toMatch(/Not docked/);
  });

  it("says what is not known", () => {
    const lost = { ...emptyScene, frame: "odom" as const, dock: null };
    expect(describeScene(lost, null)).toMatch(/which drifts\. Position of the dock unknown\.$/);
  });
});
