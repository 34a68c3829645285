import type { GatewayEvent, Http, Pose, Scene } from "@dock-gateway/client";
import { placeOf } from "../../api/places";
import { compose } from "../../store/geometry";
import {
  type FleetLayer,
  type FleetLayerPainter,
  type FleetPoses,
  type Scheme,
  SHARED_FRAME,
} from "../../store/layers";
import { cornersOf, MapImage } from "./mapImage";
import { MAP_COLORS, mapImage, type RobotMap } from "./requests";
import { mapIn } from "./robotMaps";

const ORIGIN: Pose = { x: 0, y: 0, theta: 0 };

/** The map below all robots. */
interface GroundMap {
  /** One whose map it is. */
  robot: string;
  map: RobotMap;
  /** Where its frame lies in the one that robots share. */
  at: Pose;
}

/**
 * The maps of all robots as they come. A robot without a frame that it shares is placed by its map, if that is the map
 * of the others: its scene is then as if it were in their frame.
 */
export class FleetMaps implements FleetLayer {
  #maps: Readonly<Record<string, RobotMap>> = {};
  #ground: GroundMap | null = null;

  /** @param httpOf What asks the gateway of a robot. */
  constructor(private readonly httpOf: (robot: string) => Http) {}

  onEvent(event: GatewayEvent, nameOf: (robot: string) => string): boolean {
    if (event.type !== "maps") return false;
    this.#maps = Object.fromEntries(Object.entries(event.maps).map(([robot, map]) => [nameOf(robot), map]));
    return true;
  }

  get frame(): string | null {
    return this.#ground === null ? null : (this.#ground.map.map?.frame ?? "map");
  }

  arrange(scenes: FleetPoses): FleetPoses {
    const ground = this.#findGround(scenes);
    this.#ground = ground;
    if (ground === null) return scenes;
    return Object.fromEntries(
      Object.entries(scenes).map(([robot, scene]) => [robot, this.#share(robot, scene, ground)]),
    );
  }

  paint(scheme: Scheme, onChange: () => void): FleetLayerPainter {
    const load = () => {
      const robot = this.#ground?.robot ?? "/";
      return mapImage(this.httpOf(robot), placeOf(robot).name, MAP_COLORS[scheme]);
    };
    const image = new MapImage(load, onChange);
    return {
      ground: () => {
        image.show(this.#ground?.map.map ?? null);
        return image.placeAt(this.#ground?.at ?? null);
      },
      corners: () => cornersOf(this.#ground?.map.map ?? null, this.#ground?.at ?? null),
      close: () => image.close(),
    };
  }

  #findGround(scenes: FleetPoses): GroundMap | null {
    const known = Object.entries(scenes).flatMap(([robot, scene]) => {
      const map = this.#maps[robot];
      return map?.map == null ? [] : [{ robot, scene, map }];
    });
    for (const { robot, scene, map } of known) {
      const at = scene.frame === SHARED_FRAME ? mapIn(scene, map) : null;
      if (at !== null) return { robot, map, at };
    }
    if (Object.values(scenes).some(({ frame }) => frame === SHARED_FRAME)) return null;
    const first = known.find(({ map }) => map.odom !== null);
    return first === undefined ? null : { robot: first.robot, map: first.map, at: ORIGIN };
  }

  #share(robot: string, scene: Scene, ground: GroundMap): Scene {
    const map = this.#maps[robot];
    if (scene.frame === SHARED_FRAME || map?.odom == null) return scene;
    if (map.topic !== ground.map.topic) return scene;
    return { ...scene, frame: SHARED_FRAME, robot: compose(ground.at, compose(map.odom, scene.robot)) };
  }
}
