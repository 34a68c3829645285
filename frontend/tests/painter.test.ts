// @vitest-environment jsdom

import type { Pose } from "@dock-gateway/client";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { Around } from "../src/scene/around";
import { Camera } from "../src/scene/camera";
import { Gestures } from "../src/scene/gestures";
import { drawGrid } from "../src/scene/ground";
import { Painter } from "../src/scene/painter";
import { handlePlace } from "../src/scene/renderer";
import { toScreen } from "../src/scene/view";
import { compose, type Point, type View } from "../src/store/geometry";
import type { LayerView, SceneLayer } from "../src/store/layers";
import { FADE_MS, SceneBuffer } from "../src/store/sceneBuffer";
import { SCENE_COLORS } from "../src/ui/tokens";
import { emptyScene } from "./events";

/** Beats are counted by the clock: what is drawn when must not depend on when the test runs. */
const START = Date.UTC(2026, 10, 21);
const SIZE = { width: 600, height: 400 };

const isText = ([name]: [string, unknown[]]) => name === "fillText";

/** A context that takes everything and remembers the calls. */
function fakeContext() {
  const calls: [string, unknown[]][] = [];
  const measureText = (text: string) => ({ width: 6 * text.length });
  const context = new Proxy({ measureText } as Record<string, unknown>, {
    get: (target, name: string) => target[name] ?? ((...values: unknown[]) => calls.push([name, values])),
  });
  return { context: context as unknown as CanvasRenderingContext2D, calls };
}

describe("the ground", () => {
  it("has metres along its top and its left, with the decimals of its grid", () => {
    const { context, calls } = fakeContext();
    const written = (view: View) => {
      calls.length = 0;
      drawGrid(context, { view, size: SIZE, colors: SCENE_COLORS.light });
      const texts = calls.filter(([name]) => name === "fillText").map(([, values]) => values);
      const top = texts.filter(([text, , y]) => y === 4 && text !== "m").map(([text]) => text);
      return { top, left: texts.filter(([, x, y]) => x === 4 && y !== 4).map(([text]) => text) };
    };
    // Six metres from left to right, and four from the bottom to the top.
    expect(written({ x: 0, y: 0, scale: 100 })).toEqual({
      top: ["−2.5", "−2.0", "−1.5", "−1.0", "−0.5", "0.0", "0.5", "1.0", "1.5", "2.0", "2.5"],
      left: ["−1.0", "−0.5", "0.0", "0.5", "1.0", "1.5"],
    });
    expect(written({ x: 100, y: 0, scale: 10 }).top).toEqual([
      "75",
      "80",
      "85",
      "90",
      "95",
      "100",
      "105",
      "110",
      "115",
      "120",
      "125",
    ]);
  });
});

describe("the painter", () => {
  let canvas: HTMLCanvasElement;
  let buffer: SceneBuffer;
  let camera: Camera;
  let painter: Painter;
  let calls: [string, unknown[]][];
  let groundCalls: [string, unknown[]][];

  const pictures = () => calls.filter(([name]) => name === "drawImage").length;
  const frames = (milliseconds: number) => vi.advanceTimersByTime(milliseconds);

  beforeEach(() => {
    vi.useFakeTimers({
      now: START,
      toFake: [
        "requestAnimationFrame",
        "cancelAnimationFrame",
        "performance",
        "Date",
        "setTimeout",
        "clearTimeout",
      ],
    });
    canvas = document.createElement("canvas");
    document.body.append(canvas);
    const fake = fakeContext();
    const ground = fakeContext();
    calls = fake.calls;
    groundCalls = ground.calls;
    vi.spyOn(HTMLCanvasElement.prototype, "getContext").mockImplementation(function (
      this: HTMLCanvasElement,
    ) {
      const { context } = this === canvas ? fake : ground;
      return Object.assign(context, { canvas: this }) as never;
    });
    vi.stubGlobal("devicePixelRatio", 2);
    buffer = new SceneBuffer();
    camera = new Camera();
    painter = new Painter(canvas, camera, buffer, SCENE_COLORS.light, false);
    painter.resize(SIZE);
    frames(100);
  });
  afterEach(() => {
    painter.destroy();
    canvas.remove();
  });

  function push(change: Partial<typeof emptyScene> = {}) {
    buffer.push({ ...emptyScene, ...change }, performance.now());
  }

  it("names the frame, and the dock where that is known", () => {
    const texts = () => calls.flatMap(([name, [text]]) => (name === "fillText" ? [text] : []));
    push({ frame: "odom", dock: null });
    frames(50);
    expect(texts()).toContain("frame odom");
    expect(texts()).not.toContain("dock");
    push();
    frames(2000);
    expect(texts()).toEqual(expect.arrayContaining(["frame world", "dock"]));
  });

  it("draws the robot with its footprint, wherever it is or is to stand", () => {
    const docked = { x: -0.2, y: 0, theta: 0 };
    const points = [
      { x: 0.4, y: 0.3 },
      { x: -0.4, y: 0.3 },
      { x: 0, y: -0.45 },
    ];
    push({ docked, footprint: { radius: 0.5, points } });
    frames(2000);
    const lines = calls.filter(([name]) => name === "lineTo").map(([, place]) => place);
    for (const pose of [emptyScene.robot, docked]) {
      for (const { x, y } of points) {
        const place = toScreen(painter.view, SIZE, compose(pose, { x, y, theta: 0 }));
        expect(lines).toContainEqual([place.x, place.y]);
      }
    }
    const round = () =>
      calls.some(([name, [, , radius]]) => name === "arc" && radius === 0.15 * painter.view.scale);
    expect(round()).toBe(false);
    push({ docked });
    frames(2000);
    expect(round()).toBe(true);
  });

  it("draws nothing while nothing is known", () => {
    frames(1000);
    expect(pictures()).toBe(0);
  });

  it("draws at the screen's resolution", () => {
    push();
    frames(50);
    expect([canvas.width, canvas.height]).toEqual([1200, 800]);
    expect(calls.find(([name]) => name === "setTransform")?.[1]).toEqual([2, 0, 0, 2, 0, 0]);
  });

  it("draws once for many events in one frame, and not at all when nothing changes", () => {
    push();
    push();
    push();
    frames(40);
    expect(pictures()).toBe(1);
    frames(5000);
    expect(pictures()).toBe(1);
  });

  it("draws some fifteen times a second while scenes come", () => {
    for (let count = 0; count < 50; count += 1) {
      push({ robot: { x: -1.5 + count / 100, y: 0.4, theta: -0.3 } });
      frames(20);
    }
    expect(pictures()).toBeGreaterThanOrEqual(14);
    expect(pictures()).toBeLessThanOrEqual(17);
  });

  it("draws on while the robot glides, then no more", () => {
    push();
    frames(200);
    const before = pictures();
    push({ robot: { x: -1.45, y: 0.4, theta: -0.3 } });
    frames(300);
    const gliding = pictures() - before;
    expect(gliding).toBeGreaterThan(2);
    frames(5000);
    expect(pictures() - before).toBe(gliding);
  });

  it("does not draw a robot again that moves by less than can be seen, as odometry that is never at rest", () => {
    push();
    frames(1000);
    const before = pictures();
    const pixel = 1 / painter.view.scale;
    for (let count = 0; count < 50; count += 1) {
      push({ robot: { x: -1.5 + ((count % 3) * pixel) / 10, y: 0.4, theta: -0.3 } });
      frames(20);
    }
    expect(pictures()).toBe(before);
    push({ robot: { x: -1.5 + pixel, y: 0.4, theta: -0.3 } });
    frames(300);
    expect(pictures()).toBeGreaterThan(before);
  });

  it("draws the ground once, and of the trail what is new", () => {
    const lines = () => groundCalls.filter(([name]) => name === "stroke").length;
    for (let count = 0; count < 20; count += 1) {
      push({ robot: { x: -1.5 + count / 50, y: 0.4, theta: 0 } });
      frames(50);
    }
    const before = lines();
    push({ robot: { x: -1.1, y: 0.4, theta: 0 } });
    frames(200);
    expect(pictures()).toBeGreaterThan(10);
    expect(lines()).toBe(before + 1);
    painter.zoomBy(2);
    frames(1000);
    expect(lines()).toBeGreaterThan(before + 10);
    groundCalls.length = 0;
    buffer.trail.clear();
    push({ robot: { x: -1, y: 0.4, theta: 0 } });
    frames(200);
    expect(groundCalls.filter(([name]) => name === "setTransform")).toHaveLength(1);
  });

  it("draws the way of a robot that stands still once it is known", () => {
    push();
    frames(500);
    const before = pictures();
    const { robot } = emptyScene;
    const scene = { ...emptyScene, robot: { ...robot, x: robot.x - 0.1 } };
    const time = new Date(performance.now() - 60_000).toISOString();
    buffer.recall([{ type: "pose", id: "1", time, goal_id: "a", action_name: "/dock", scene }]);
    frames(500);
    expect(pictures()).toBe(before + 1);
  });

  it("draws nothing out of sight, and what there is as soon as it is in sight", () => {
    painter.inSight = false;
    push();
    frames(500);
    push({ robot: { x: -1.2, y: 0.4, theta: -0.3 } });
    frames(500);
    expect(pictures()).toBe(0);
    painter.inSight = true;
    frames(20);
    expect(pictures()).toBe(1);
  });

  it("neither glides nor fades smoothly where motion is not wanted", () => {
    painter.destroy();
    painter = new Painter(canvas, camera, buffer, SCENE_COLORS.light, true);
    push();
    push({ robot: { x: -1.45, y: 0.4, theta: -0.3 }, marker: { x: 0, y: 0, theta: 0 } });
    frames(20);
    expect(painter.robot?.x).toBe(-1.45);
    frames(FADE_MS - 20);
    expect(pictures()).toBeGreaterThan(3);
    expect(pictures()).toBeLessThan(12);
    frames(5000);
    const all = pictures();
    frames(5000);
    expect(pictures()).toBe(all);
  });

  it("draws on while a detection fades", () => {
    push({ marker: { x: 0, y: 0, theta: 0 } });
    frames(FADE_MS / 2);
    const half = pictures();
    frames(FADE_MS);
    expect(pictures()).toBeGreaterThan(half);
    const all = pictures();
    frames(5000);
    expect(pictures()).toBe(all);
  });

  it("keeps a view that somebody chose, until all is to be shown again", () => {
    push();
    frames(1000);
    const own = painter.view;
    painter.zoomBy(3);
    frames(2000);
    expect(painter.view.scale).toBeCloseTo(own.scale * 3, 1);
    push({ robot: { x: -3, y: 0, theta: 0 } });
    frames(2000);
    expect(painter.view.scale).toBeCloseTo(own.scale * 3, 1);
    painter.showAll();
    frames(2000);
    expect(painter.view.scale).toBeLessThan(own.scale);
  });

  describe("with a layer", () => {
    let seen = emptyView();
    let change = () => {};
    let around: Around;
    let corners: Point[];
    const layer: SceneLayer = {
      subscribe: () => () => {},
      groundIn: () => null,
      paint: (_, onChange) => {
        change = onChange;
        return {
          viewIn: () => seen,
          cornersIn: () => corners,
          close: () => {},
        };
      },
    };
    const data = { layers: [layer], docks: [], frameIn: () => null, blocked: false, idle: false };
    function emptyView(): LayerView {
      return { ground: null, lines: [], dots: [] };
    }

    beforeEach(() => {
      seen = emptyView();
      corners = [
        { x: -5, y: -5 },
        { x: 15, y: 5 },
      ];
      painter.destroy();
      around = new Around(data, "light");
      painter = new Painter(canvas, camera, buffer, SCENE_COLORS.light, false, around);
      painter.resize(SIZE);
      push();
      frames(2000);
    });

    it.each([
      { idle: true, beyond: 15, shows: true },
      { idle: false, beyond: 15, shows: false },
      { idle: true, beyond: 100, shows: false },
    ])("shows a room by itself where no goal runs: idle $idle, $beyond m", ({ idle, beyond, shows }) => {
      corners = [
        { x: -5, y: -5 },
        { x: beyond, y: 5 },
      ];
      around.know({ ...data, idle });
      frames(2000);
      expect(SIZE.width / painter.view.scale > 20).toBe(shows);
    });

    it("shows the whole ground", () => {
      painter.showGround();
      frames(2000);
      expect([painter.view.x, painter.view.y]).toEqual([5, 0]);
      expect(painter.view.scale * 20).toBeLessThanOrEqual(SIZE.width);
    });

    it("draws its ground below the numbers of the grid, its lines below docks, and its dots above them", () => {
      const order: string[] = [];
      const note = (name: string, after: [string, unknown[]][]) => order.push(`${name} ${after.length > 0}`);
      calls.length = 0;
      groundCalls.length = 0;
      seen = {
        ground: { draw: () => note("ground, numbers before it", groundCalls.filter(isText)) },
        lines: [
          {
            points: [
              { x: 0, y: 0 },
              { x: 1, y: 0 },
            ],
            color: "path",
          },
        ],
        dots: [{ points: [{ x: 1, y: 1 }], color: "scan" }],
      };
      change();
      frames(100);
      expect(order).toEqual(["ground, numbers before it false"]);
      expect(groundCalls.some(isText)).toBe(true);
      const line = calls.findIndex(([name, values]) => name === "setLineDash" && `${values}` === "7,5");
      const dots = calls.findIndex(([name]) => name === "rect");
      const dock = calls.findIndex(([name, [text]]) => name === "fillText" && text === "dock");
      expect(line).toBeGreaterThan(-1);
      expect(dots).toBeGreaterThan(line);
      expect(dock).toBeGreaterThan(dots);
    });

    it("draws again only where it looks different", () => {
      const before = pictures();
      change();
      frames(1000);
      expect(pictures()).toBe(before);
      seen = { ...emptyView(), ground: { draw: () => {} } };
      change();
      frames(1000);
      expect(pictures()).toBe(before + 1);
      seen = { ...seen, dots: [{ points: [{ x: 1, y: 1 }], color: "scan" }] };
      change();
      frames(1000);
      expect(pictures()).toBe(before + 2);
    });
  });

  describe("that follows the robot", () => {
    const onFollow = vi.fn<(scale: number | null) => void>();
    const drive = (x: number) => {
      push({ robot: { x, y: 0.4, theta: 0 } });
      frames(300);
    };
    const middle = () => ({ x: painter.view.x, y: painter.view.y });

    beforeEach(() => {
      onFollow.mockClear();
      push();
      frames(1000);
      camera.onFollow = onFollow;
    });

    it("keeps it in the middle, at the scale that was seen", () => {
      const { scale } = painter.view;
      painter.follow();
      frames(2000);
      expect(middle()).toEqual({ x: emptyScene.robot.x, y: emptyScene.robot.y });
      for (const x of [-1.4, -1.3, -1.2]) {
        drive(x);
        expect(middle()).toEqual({ x, y: 0.4 });
      }
      expect(painter.view.scale).toBe(scale);
      expect(onFollow.mock.calls).toEqual([[scale]]);
    });

    it("glides to another scale, and has the robot in the middle on its way there", () => {
      painter.follow(200);
      frames(2000);
      painter.zoomBy(1.5, { x: 10, y: 10 });
      push({ robot: { x: -1.2, y: 0.4, theta: 0 } });
      frames(30);
      expect(painter.view.scale).toBeGreaterThan(200);
      expect(painter.view.scale).toBeLessThan(300);
      frames(2000);
      expect(painter.view).toEqual({ x: -1.2, y: 0.4, scale: 300 });
      expect(onFollow.mock.calls).toEqual([[200], [300]]);
    });

    it("keeps the ground still under a robot that stands, and under one that is dragged", () => {
      painter.follow(200);
      frames(2000);
      const { view } = painter;
      drive(emptyScene.robot.x + 0.001);
      expect(painter.view).toBe(view);
      painter.showGhost(emptyScene.robot);
      drive(-1);
      expect(painter.view).toBe(view);
    });

    it.each([
      ["pans", () => painter.panBy(40, 0)],
      ["wants to see all", () => painter.showAll()],
    ])("does so until somebody %s", (_, act) => {
      painter.follow(200);
      frames(2000);
      act();
      expect(onFollow).toHaveBeenLastCalledWith(null);
      frames(2000);
      const { view } = painter;
      drive(-1.4);
      expect(painter.view).toEqual(view);
    });

    it("goes on where the colours change", () => {
      painter.follow(200);
      painter.destroy();
      painter = new Painter(canvas, camera, buffer, SCENE_COLORS.dark, false);
      painter.invalidate();
      frames(2000);
      drive(-1.3);
      expect(painter.view).toEqual({ x: -1.3, y: 0.4, scale: 200 });
    });
  });

  it("hands its view on to the next one, as when the colours change", () => {
    push();
    painter.zoomBy(2);
    frames(1000);
    const next = new Painter(canvas, camera, buffer, SCENE_COLORS.dark, false);
    expect(next.view).toEqual(painter.view);
    next.destroy();
  });

  it("draws no more once it is destroyed", () => {
    push();
    painter.destroy();
    push();
    frames(1000);
    expect(pictures()).toBe(0);
  });

  describe("with gestures", () => {
    let gestures: Gestures;
    const onPlace = vi.fn<(pose: Pose) => void>();
    const onGhost = vi.fn<(pose: Pose | null) => void>();

    beforeEach(() => {
      onPlace.mockClear();
      onGhost.mockClear();
      canvas.setPointerCapture = () => {};
      gestures = new Gestures(canvas, painter, onPlace, onGhost);
      painter.handle = true;
      push();
      frames(1000);
    });
    afterEach(() => gestures.destroy());

    const on = (pose: Pose) => toScreen(painter.view, painter.size, pose);
    function pointer(type: string, { x, y }: { x: number; y: number }, pointerId = 1) {
      canvas.dispatchEvent(new PointerEvent(type, { clientX: x, clientY: y, pointerId, button: 0 }));
    }
    function key(key: string, modifiers: KeyboardEventInit = {}) {
      const event = new KeyboardEvent("keydown", { key, cancelable: true, ...modifiers });
      canvas.dispatchEvent(event);
      return event.defaultPrevented;
    }

    it("drag the robot to another place, and keep its heading", () => {
      const { robot } = emptyScene;
      const target = { x: -1, y: -0.2, theta: 0 };
      pointer("pointerdown", on(robot));
      pointer("pointermove", on(target));
      expect(painter.ghost?.x).toBeCloseTo(-1);
      pointer("pointerup", on(target));
      const [placed] = onPlace.mock.calls[0] ?? [];
      expect(placed?.x).toBeCloseTo(-1);
      expect(placed?.y).toBeCloseTo(-0.2);
      expect(placed?.theta).toBe(robot.theta);
    });

    it("take hold of a large robot anywhere on it", () => {
      const { robot } = emptyScene;
      const edge = { ...robot, x: robot.x - 0.7 };
      pointer("pointerdown", on(edge));
      pointer("pointermove", on({ ...edge, x: edge.x + 0.1 }));
      expect(painter.ghost).toBeNull();
      pointer("pointerup", on(edge));
      push({ footprint: { radius: 0.8, points: null } });
      frames(1000);
      pointer("pointerdown", on(edge));
      pointer("pointermove", on({ ...edge, x: edge.x + 0.1 }));
      expect(painter.ghost?.x).toBeCloseTo(robot.x + 0.1);
      pointer("pointerup", on(edge));
    });

    it("turn the robot by its knob", () => {
      const { robot } = emptyScene;
      pointer("pointerdown", handlePlace(painter.view, painter.size, robot, painter.radius));
      const above = { x: robot.x, y: robot.y + 0.5, theta: 0 };
      pointer("pointermove", on(above));
      pointer("pointerup", on(above));
      const [placed] = onPlace.mock.calls[0] ?? [];
      expect(placed).toMatchObject({ x: robot.x, y: robot.y });
      expect(placed?.theta).toBeCloseTo(Math.PI / 2);
    });

    it("do not place a robot that was only touched, nor one that is real", () => {
      const place = on(emptyScene.robot);
      pointer("pointerdown", place);
      pointer("pointerup", place);
      painter.handle = false;
      pointer("pointerdown", place);
      pointer("pointermove", { x: place.x + 40, y: place.y });
      pointer("pointerup", place);
      expect(onPlace).not.toHaveBeenCalled();
    });

    it("move the ground beside the robot", () => {
      const before = painter.view;
      pointer("pointerdown", { x: 300, y: 390 });
      pointer("pointermove", { x: 340, y: 370 });
      pointer("pointerup", { x: 340, y: 370 });
      expect(painter.view.x).toBeCloseTo(before.x - 40 / before.scale);
      expect(painter.view.y).toBeCloseTo(before.y - 20 / before.scale);
    });

    it("zoom with two fingers", () => {
      const before = painter.view.scale;
      pointer("pointerdown", { x: 200, y: 390 }, 1);
      pointer("pointerdown", { x: 300, y: 390 }, 2);
      pointer("pointermove", { x: 400, y: 390 }, 2);
      frames(1000);
      expect(painter.view.scale).toBeCloseTo(before * 2, 1);
    });

    it("zoom with the wheel and Ctrl, and leave the wheel alone to the page", () => {
      const before = painter.view.scale;
      const scroll = new WheelEvent("wheel", { deltaY: -100, cancelable: true });
      canvas.dispatchEvent(scroll);
      expect(scroll.defaultPrevented).toBe(false);
      canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: -100, ctrlKey: true, cancelable: true }));
      frames(1000);
      expect(painter.view.scale).toBeGreaterThan(before * 1.2);
    });

    it("place by keyboard: arrows move, with Shift they turn, Enter does it", () => {
      const { robot } = emptyScene;
      expect(key("ArrowRight")).toBe(true);
      key("ArrowUp");
      key("ArrowLeft", { shiftKey: true });
      const ghost = painter.ghost;
      expect(ghost?.x).toBeCloseTo(robot.x + 0.05);
      expect(ghost?.y).toBeCloseTo(robot.y + 0.05);
      expect(ghost?.theta).toBeCloseTo(robot.theta + (5 * Math.PI) / 180);
      expect(onGhost).toHaveBeenLastCalledWith(ghost);
      key("Enter");
      expect(onPlace).toHaveBeenCalledWith(ghost);
    });

    it("give up with Escape, and leave every other key to the page", () => {
      expect(key("Escape")).toBe(false);
      key("ArrowRight");
      expect(key("Escape")).toBe(true);
      expect(painter.ghost).toBeNull();
      expect(onGhost).toHaveBeenLastCalledWith(null);
      expect(key("Enter")).toBe(false);
      expect(key("Tab")).toBe(false);
      expect(onPlace).not.toHaveBeenCalled();
    });

    it("move and zoom the picture by keyboard where no robot can be placed", () => {
      painter.handle = false;
      const before = painter.view;
      key("ArrowRight");
      expect(painter.view.x).toBeGreaterThan(before.x);
      key("+");
      frames(1000);
      expect(painter.view.scale).toBeGreaterThan(before.scale);
      key("0");
      frames(1000);
      expect(painter.view.scale).toBeCloseTo(before.scale);
    });
  });
});
