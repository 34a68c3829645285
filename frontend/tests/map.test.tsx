import type { GatewayEvent, Scene } from "@dock-gateway/client";
import { act, screen, waitFor, within } from "@testing-library/react";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { placement } from "../src/pages/map/MapPage";
import { FleetScenes } from "../src/pages/map/scenes";
import { FleetStage } from "../src/pages/map/stage";
import { Camera } from "../src/scene/camera";
import { toScreen } from "../src/scene/view";
import { SCENE_COLORS } from "../src/ui/tokens";
import { alert, at, emptyScene, latched, robot } from "./events";
import { fakeGateway, renderPage } from "./page";
import { streams } from "./streams";

/** A robot at `x` in a frame. */
const scene = (x: number, frame: Scene["frame"] = "world"): Scene => ({
  ...emptyScene,
  frame,
  robot: { x, y: 1, theta: Math.PI / 2 },
});
const event = (scenes: Record<string, Scene>): GatewayEvent => ({ type: "scenes", time: at(1), scenes });

beforeEach(() => {
  vi.stubGlobal("fetch", async () => Response.json({ rules: [] }));
});

describe("the scenes of all robots", () => {
  it("have the same frames for as long as robots only move", () => {
    const scenes = new FleetScenes([]);
    const listener = vi.fn();
    const forget = scenes.subscribe(listener);
    expect(scenes.frames).toBeNull();
    scenes.onEvent({ type: "heartbeat", id: "1", time: at(1) });
    expect(listener).not.toHaveBeenCalled();
    scenes.onEvent(event({ "/a": scene(1), "/b": scene(2, "odom") }));
    const { frames } = scenes;
    expect([...(frames ?? [])]).toEqual([
      ["/a", "world"],
      ["/b", "odom"],
    ]);
    scenes.onEvent(event({ "/a": scene(1.1), "/b": scene(2, "odom") }));
    expect(scenes.frames).toBe(frames);
    expect(scenes.latest["/a"]?.robot.x).toBe(1.1);
    const others: Record<string, Scene>[] = [
      { "/a": scene(1) },
      { "/c": scene(1) },
      { "/c": scene(1, "odom") },
    ];
    for (const other of others) {
      const before = scenes.frames;
      scenes.onEvent(event(other));
      expect(scenes.frames).not.toBe(before);
    }
    expect(listener).toHaveBeenCalledTimes(5);
    forget();
    scenes.onEvent(event({}));
    expect(listener).toHaveBeenCalledTimes(5);
  });
});

describe("a robot is", () => {
  const world = new Map([["/robot1", "world" as const]]);
  const markOf = (change: Parameters<typeof robot>[1], ...alerts: Parameters<typeof alert>[1][]) =>
    placement(
      [robot("/robot1", change)],
      world,
      alerts.map((each, index) => alert(`${index}`, each)),
    ).placed[0]?.mark;
  const dead = { ...robot("/robot1").battery, stale: true };

  it("as it should be, or marked with the worst that is wrong with it", () => {
    expect(markOf({})).toBeNull();
    expect(markOf({}, { robot: "/robot2" })).toBeNull();
    expect(markOf({}, { acknowledged: { by: "Ada", acknowledged_at: at(1) } })).toBeNull();
    expect(markOf({}, {}, { severity: "critical", title: "Goal lost" })).toEqual({
      level: "critical",
      words: "Goal lost",
    });
    expect(markOf({ stop: latched("Ada") }, {})).toEqual({ level: "critical", words: "Stopped" });
    expect(markOf({ dock: null, undock: null, battery: dead })).toEqual({
      level: "warning",
      words: "Unreachable",
    });
  });

  it("missing for a reason, unless nothing was ever heard of it", () => {
    const nothing = { dock: null, undock: null, battery: { ...dead, state: null } };
    const robots = [
      robot("/robot10"),
      robot("/robot9", { simulated: true }),
      robot("/robot2"),
      robot("/robot3", { dock: null, undock: null, battery: dead }),
      robot("/", nothing),
      robot("/robot1"),
    ];
    const { placed, missing } = placement(robots, new Map([...world, ["/robot2", "odom" as const]]), []);
    expect(placed.map((each) => each.robot.name)).toEqual(["/robot1"]);
    expect(missing.map((each) => [each.robot.name, each.why])).toEqual([
      ["/robot2", "Only odometry, in a frame of its own"],
      ["/robot3", "Unreachable"],
      ["/robot9", "No pose from its simulator"],
      ["/robot10", "No simulator, no odometry yet"],
    ]);
  });
});

describe("the stage", () => {
  it("puts robots of the shared frame in their places, each dock once", () => {
    vi.useFakeTimers({ toFake: ["requestAnimationFrame", "cancelAnimationFrame", "performance"] });
    const calls: [string, unknown[]][] = [];
    const context = new Proxy({} as Record<string, unknown>, {
      get: (target, name: string) => target[name] ?? ((...values: unknown[]) => calls.push([name, values])),
    });
    vi.spyOn(HTMLCanvasElement.prototype, "getContext").mockReturnValue(context as never);
    const elements = new Map(["/a", "/b", "/c"].map((name) => [name, document.createElement("li")]));
    const scenes = new FleetScenes([]);
    const canvas = document.createElement("canvas");
    const camera = new Camera();
    const means = { canvas, colors: SCENE_COLORS.light, scheme: "light", reducedMotion: true } as const;
    const stage = new FleetStage(means, camera, elements, scenes);
    stage.resize({ width: 600, height: 400 });
    scenes.onEvent(event({ "/a": scene(-2), "/b": scene(3), "/c": scene(9, "odom"), "/gone": scene(0) }));
    vi.advanceTimersByTime(50);
    const placeOf = (name: string) => elements.get(name)?.style.transform;
    const expected = (x: number, y: number) => {
      const place = toScreen(stage.view, stage.size, { x, y });
      return `translate(${place.x.toFixed(1)}px, ${place.y.toFixed(1)}px)`;
    };
    expect([placeOf("/a"), placeOf("/b"), placeOf("/c")]).toEqual([expected(-2, 1), expected(3, 1), ""]);
    expect(elements.get("/a")?.style.getPropertyValue("--turn")).toBe("-1.571rad");
    expect(elements.get("/c")?.dataset.placed).toBeUndefined();
    const style = (name: string) => elements.get("/a")?.style.getPropertyValue(name);
    expect([style("--outline"), style("--arrow")]).toEqual(["circle(47%)", "1.000"]);
    expect(calls.filter(([name]) => name === "fill")).toHaveLength(3); // a dock, with its two contacts

    const points = [
      { x: 0.5, y: 0 },
      { x: 0, y: 0.5 },
      { x: 0, y: -0.25 },
    ];
    scenes.onEvent(event({ "/a": { ...scene(-2), footprint: { radius: 0.5, points } }, "/b": scene(3) }));
    vi.advanceTimersByTime(50);
    expect(style("--outline")).toBe("polygon(97.0% 50.0%, 50.0% 3.0%, 50.0% 73.5%)");
    expect(style("--arrow")).toBe("0.333");
    expect(style("--size")).toBe(`${Math.max(24, stage.view.scale).toFixed(1)}px`);

    const next = new FleetStage(means, camera, elements, scenes);
    stage.destroy();
    next.panBy(40, 0);
    next.zoomBy(2);
    vi.advanceTimersByTime(50);
    const { view } = next;
    scenes.onEvent(event({ "/a": scene(-20) }));
    vi.advanceTimersByTime(50);
    expect(next.view).toEqual(view);
    next.inSight = false;
    next.showAll();
    vi.advanceTimersByTime(50);
    expect(next.view).toEqual(view);
    next.inSight = true;
    vi.advanceTimersByTime(50);
    expect(next.view.x).toBeLessThan(-9);
    next.destroy();
    vi.useRealTimers();
  });
});

it("names those in trouble first where there is no room for every name", () => {
  vi.useFakeTimers({ toFake: ["requestAnimationFrame", "cancelAnimationFrame", "performance"] });
  vi.spyOn(HTMLElement.prototype, "offsetWidth", "get").mockReturnValue(60);
  vi.spyOn(HTMLElement.prototype, "offsetHeight", "get").mockReturnValue(16);
  const context = new Proxy({}, { get: () => () => {} });
  vi.spyOn(HTMLCanvasElement.prototype, "getContext").mockReturnValue(context as never);
  const elements = new Map(
    Object.entries({ "/a": "", "/b": "warning", "/c": "critical", "/d": "" }).map(([name, level]) => {
      const element = document.createElement("li");
      if (level !== "") element.dataset.level = level;
      element.innerHTML = "<span data-label></span>";
      return [name, element] as const;
    }),
  );
  const scenes = new FleetScenes([]);
  const canvas = document.createElement("canvas");
  const means = { canvas, colors: SCENE_COLORS.light, scheme: "light", reducedMotion: true } as const;
  const stage = new FleetStage(means, new Camera(), elements, scenes);
  stage.resize({ width: 600, height: 400 });
  const crowded = (poses: Record<string, Scene>) => {
    scenes.onEvent(event(poses));
    vi.advanceTimersByTime(50);
    return [...elements].filter(([, { dataset }]) => dataset.crowded !== undefined).map(([name]) => name);
  };
  const there = { "/a": scene(0), "/b": scene(0.01), "/d": scene(9) };
  expect(crowded(there)).toEqual(["/a"]);
  expect(crowded({ ...there, "/c": scene(0.02) })).toEqual(["/a", "/b"]);
  expect(crowded({ ...there, "/b": scene(4), "/c": scene(-4) })).toEqual([]);
  stage.destroy();
  vi.useRealTimers();
});

describe("the map's page", () => {
  const robots = [
    robot("/robot1", { display_name: "Left forklift" }),
    robot("/robot2", { stop: latched("Ada") }),
    robot("/robot3"),
  ];
  const open = async () => {
    const page = renderPage(fakeGateway(), { robots }, "/ui/map");
    await screen.findByRole("heading", { name: "Map" });
    const stream = await waitFor(() => {
      const found = streams.find(({ url }) => url.includes("scenes"));
      if (found === undefined) throw new Error("no stream");
      return found;
    });
    const hear = (scenes: Record<string, Scene>) => act(() => stream.handlers.onEvent(event(scenes)));
    return { ...page, stream, hear };
  };
  const names = (list: string) =>
    within(screen.getByRole("list", { name: list }))
      .getAllByRole("listitem")
      .map(({ textContent }) => textContent);

  it("has a link for each robot, and the others beside them, from one stream", async () => {
    const { hear, stream, user } = await open();
    expect(screen.queryByRole("list", { name: "Robots on the map" })).toBeNull();
    hear({ "/robot1": scene(0), "/robot2": scene(1) });
    expect(names("Robots on the map")).toEqual(["/robot2Stopped", "Left forklift"]);
    expect(names("Robots that are not on the map")).toEqual(["/robot3No simulator, no odometry yet"]);
    expect(screen.getByTestId("on map /robot2").dataset.level).toBe("critical");
    expect(screen.getByTestId("on map /robot1").dataset.level).toBeUndefined();
    hear({ "/robot1": scene(0), "/robot2": scene(1), "/robot3": scene(2) });
    expect(names("Robots on the map")).toHaveLength(3);
    expect(screen.queryByText("Not on the map")).toBeNull();
    expect(streams.filter(({ url }) => url.includes("scenes"))).toHaveLength(1);
    await user.click(screen.getByRole("link", { name: "Left forklift" }));
    await screen.findByRole("heading", { name: /Left forklift/ });
    expect(stream.closed).toBe(true);
  });

  it("says why it is empty", async () => {
    const { hear } = await open();
    hear({ "/robot1": scene(0, "odom") });
    expect(screen.getByText("No robot on this map")).toBeDefined();
    expect(names("Robots that are not on the map").at(-1)).toMatch(/odometry, in a frame of its own/);
  });
});
