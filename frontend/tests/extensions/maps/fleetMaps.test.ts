import type { GatewayEvent, Http, Scene } from "@dock-gateway/client";
import { describe, expect, it } from "vitest";
import { FleetMaps } from "../../../src/extensions/maps/fleetMaps";
import { FleetScenes } from "../../../src/pages/map/scenes";
import { at, emptyScene } from "../../events";

/** A robot at `x` in a frame. */
const scene = (x: number, frame: Scene["frame"] = "world"): Scene => ({
  ...emptyScene,
  frame,
  robot: { x, y: 1, theta: Math.PI / 2 },
});
const event = (scenes: Record<string, Scene>): GatewayEvent => ({ type: "scenes", time: at(1), scenes });

describe("a map that robots share", () => {
  const grid = {
    ...{ revision: "1", stamped_at: null, frame: "map", resolution: 0.05, width: 10, height: 10 },
    origin: { x: 0, y: 0, theta: 0 },
  };
  const map = (x: number, topic = "/map") => ({ topic, map: grid, odom: { x, y: 0, theta: 0 }, hint: null });
  const maps = (maps: Record<string, ReturnType<typeof map>>) => ({
    type: "maps" as const,
    time: at(1),
    maps,
  });
  const open = (nameOf?: (robot: string) => string) => {
    const layer = new FleetMaps(() => ({}) as Http);
    return { layer, scenes: new FleetScenes([layer], ["maps"], nameOf) };
  };

  it("places those that tell only odometry", () => {
    const { scenes } = open();
    scenes.onEvent(event({ "/a": scene(1, "odom"), "/b": scene(2, "odom"), "/c": scene(3, "odom") }));
    expect([scenes.frames?.get("/a"), scenes.hasGround]).toEqual(["odom", false]);
    scenes.onEvent(maps({ "/a": map(10), "/b": map(20), "/c": map(30, "/other/map") }));
    expect([scenes.frame, scenes.latest["/a"]?.robot.x, scenes.latest["/b"]?.robot.x]).toEqual([
      "map",
      11,
      22,
    ]);
    expect([...(scenes.frames?.values() ?? [])]).toEqual(["world", "world", "odom"]);
    expect(scenes.hasGround).toBe(true);
  });

  it("lies where a robot that tells its true pose says", () => {
    const { layer, scenes } = open();
    scenes.onEvent(maps({ "/a": map(10), "/b": map(20) }));
    expect(scenes.frames).toBeNull();
    scenes.onEvent(event({ "/a": { ...scene(1), odom: { x: 5, y: 0, theta: 0 } }, "/b": scene(2, "odom") }));
    const [corner] = layer.paint("light", () => {}).corners();
    expect([scenes.frame, corner?.x, scenes.latest["/b"]?.robot.x]).toEqual(["world", -5, 17]);
  });

  it("has the names of the page", () => {
    const { scenes } = open((robot) => `/site${robot}`);
    scenes.onEvent(maps({ "/a": map(10) }));
    scenes.onEvent(event({ "/a": scene(1, "odom") }));
    expect(scenes.latest["/site/a"]?.robot.x).toBe(11);
    expect(scenes.query.include).toBe("scenes,maps");
  });
});
