import type { EventOf, Http } from "@dock-gateway/client";
import { describe, expect, it, vi } from "vitest";
import { mapIn, RobotMaps } from "../../../src/extensions/maps/robotMaps";
import { frameIn } from "../../../src/store/layers";
import { SCENE_COLORS } from "../../../src/ui/tokens";
import { at, emptyScene } from "../../events";

const QUARTER = Math.PI / 2;
const HTTP = {} as Http;
const { scan, path } = SCENE_COLORS.light;

/** Odometry begins at (2, 3) in the map, and at (1, 0) in the frame that is drawn. */
const MAP: EventOf<"map"> = {
  type: "map",
  time: at(1),
  robot: "/",
  map: {
    topic: "/map",
    map: {
      revision: "1",
      stamped_at: null,
      frame: "map",
      resolution: 0.05,
      width: 10,
      height: 10,
      origin: { x: 0, y: 0, theta: 0 },
    },
    odom: { x: 2, y: 3, theta: QUARTER },
    hint: null,
  },
};
const SCENE = { ...emptyScene, robot: { x: 1, y: 1, theta: 0 }, odom: { x: 1, y: 0, theta: 0 } };

function mapsOf(...events: Parameters<RobotMaps["onEvent"]>[0][]): RobotMaps {
  const maps = new RobotMaps(HTTP, null);
  for (const event of events) maps.onEvent(event, 1000);
  return maps;
}

describe("frames", () => {
  it("are related by odometry", () => {
    const map = mapIn(SCENE, MAP.map);
    expect([map?.x, map?.y, map?.theta].map((each) => each?.toFixed(3))).toEqual([
      "-2.000",
      "2.000",
      "-1.571",
    ]);
    const layers = [
      mapsOf({ ...MAP, map: { ...MAP.map, map: MAP.map.map && { ...MAP.map.map, frame: "hall" } } }),
    ];
    expect(frameIn(SCENE, layers, "map")).toEqual(map);
    expect(frameIn(SCENE, layers, "hall")).toEqual(map);
    expect(layers[0]?.groundIn(SCENE)).toEqual({ frame: "hall", pose: map });
    expect(frameIn(SCENE, layers, "odom")).toEqual(SCENE.odom);
    expect(frameIn(SCENE, layers, "world")).toEqual({ x: 0, y: 0, theta: 0 });
    expect(frameIn(SCENE, layers, "elsewhere")).toBeNull();
    expect(frameIn({ ...SCENE, odom: null }, layers, "map")).toBeNull();
    expect(frameIn(SCENE, [mapsOf({ ...MAP, map: { ...MAP.map, odom: null } })], "map")).toBeNull();
    expect(mapsOf().groundIn(SCENE)).toBeNull();
  });

  it("are those of a scan, which is forgotten when it is old", () => {
    const seen = { frame: "base_link" as const, points: [[1, 0]], hint: null };
    const maps = mapsOf({ type: "scan", time: at(1), robot: "/", scan: seen });
    expect(maps.scanIn(SCENE, { x: 1, y: 1, theta: QUARTER }, 1100)).toEqual([{ x: 1, y: 2 }]);
    expect(maps.scanIn(SCENE, SCENE.robot, 9000)).toEqual([]);
  });
});

describe("what is around a robot", () => {
  const points = (frame: "odom" | "map", hint: string | null = null) => ({ frame, points: [[0, 0]], hint });

  it("is drawn where its frames are, and named in the legend", () => {
    const maps = mapsOf(
      MAP,
      { type: "scan", time: at(1), robot: "/", scan: points("odom") },
      { type: "path", time: at(1), robot: "/", path: points("map") },
    );
    expect(maps.legend("light")).toEqual([
      { name: "laser scan", color: scan, round: true },
      { name: "path", color: path },
    ]);
    const view = maps.paint("light", () => {}).viewIn(SCENE, SCENE.robot, 1100);
    expect(view.ground).toBeNull();
    expect(view.dots).toEqual([{ color: scan, points: [{ x: 1, y: 0 }] }]);
    const [line] = view.lines;
    expect([line?.color, line?.points[0]?.x.toFixed(3), line?.points[0]?.y.toFixed(3)]).toEqual([
      path,
      "-2.000",
      "2.000",
    ]);
    expect(mapsOf().legend("light")).toEqual([]);
  });

  it("is looked at as a whole while the picture of its map is on its way", () => {
    const maps = mapsOf(MAP);
    const corners = maps
      .paint("dark", () => {})
      .cornersIn({ ...SCENE, odom: { x: 2, y: 3, theta: QUARTER } });
    expect(corners.map(({ x, y }) => [x.toFixed(2), y.toFixed(2)])).toEqual([
      ["0.00", "0.00"],
      ["0.50", "0.00"],
      ["0.00", "0.50"],
      ["0.50", "0.50"],
    ]);
    expect(
      mapsOf()
        .paint("dark", () => {})
        .cornersIn(SCENE),
    ).toEqual([]);
  });

  it("says what is wrong with it; a robot without a map has none", () => {
    const none = { ...MAP, map: { topic: null, map: null, odom: null, hint: "No map." } };
    const old = { type: "scan" as const, time: at(1), robot: "/", scan: points("odom", "Old scan.") };
    expect(mapsOf(none, old).hints()).toEqual(["Old scan."]);
    expect(mapsOf({ ...MAP, map: { ...MAP.map, hint: "No transform." } }).hints()).toEqual(["No transform."]);
  });

  it("is told of where it is new", () => {
    const maps = mapsOf();
    const listener = vi.fn();
    const forget = maps.subscribe(listener);
    for (const event of [MAP, MAP, { type: "heartbeat" as const, id: "1", time: at(1) }])
      maps.onEvent(event, 0);
    expect(listener).toHaveBeenCalledTimes(1);
    forget();
  });
});
