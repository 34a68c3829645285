import type { GatewayEvent, Http, Pose, Scene } from "@dock-gateway/client";
import { compose, inverse, type Point, place } from "../../store/geometry";
import type { LayerPainter, LegendEntry, LocatedFrame, RobotLayer, Scheme } from "../../store/layers";
import { frameIn } from "../../store/layers";
import { SCENE_COLORS } from "../../ui/tokens";
import { cornersOf, MapImage } from "./mapImage";
import { MAP_COLORS, mapImage, type Points, type RobotMap } from "./requests";

/** A scan that is older is not where the laser looks now (ms). */
const SCAN_MS = 1500;
const NOTHING: readonly Point[] = [];

/** What is around a robot, as it comes: its map (without the cells), what its laser sees, and its path. */
export class RobotMaps implements RobotLayer {
  #map: RobotMap | null = null;
  #scan: Points | null = null;
  #path: Points | null = null;
  #scannedAt = Number.NEGATIVE_INFINITY;
  readonly #listeners = new Set<() => void>();

  /** @param robot Null for the one that the gateway is configured for. */
  constructor(
    private readonly http: Http,
    private readonly robot: string | null,
  ) {}

  onEvent(event: GatewayEvent, now: number): void {
    if (event.type === "map") {
      if (JSON.stringify(event.map) === JSON.stringify(this.#map)) return;
      this.#map = event.map;
    } else if (event.type === "scan") {
      this.#scan = event.scan;
      this.#scannedAt = now;
    } else if (event.type === "path") {
      if (JSON.stringify(event.path) === JSON.stringify(this.#path)) return;
      this.#path = event.path;
    } else return;
    for (const listener of this.#listeners) listener();
  }

  subscribe(listener: () => void): () => void {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }

  /** The map may have another name than `map`. */
  frameIn(scene: Scene, frame: string): Pose | null {
    return frame === "map" || frame === this.#map?.map?.frame ? mapIn(scene, this.#map) : null;
  }

  groundIn(scene: Scene): LocatedFrame | null {
    const frame = this.#map?.map?.frame;
    const pose = mapIn(scene, this.#map);
    return frame === undefined || pose === null ? null : { frame, pose };
  }

  hints(): string[] {
    const map = this.#map;
    const hints = [map?.topic === null ? null : map?.hint, this.#scan?.hint, this.#path?.hint];
    return hints.filter((each) => each != null);
  }

  legend(scheme: Scheme): LegendEntry[] {
    const { scan, path } = SCENE_COLORS[scheme];
    const shown = (points: Points | null) => points !== null && points.points.length > 0;
    return [
      ...(shown(this.#scan) ? [{ name: "laser scan", color: scan, round: true } as const] : []),
      ...(shown(this.#path) ? [{ name: "path", color: path }] : []),
    ];
  }

  paint(scheme: Scheme, onChange: () => void): LayerPainter {
    const load = () => mapImage(this.http, this.robot, MAP_COLORS[scheme]);
    const image = new MapImage(load, onChange);
    const { scan, path } = SCENE_COLORS[scheme];
    return {
      viewIn: (scene, robot, now) => {
        image.show(this.#map?.map ?? null);
        return {
          ground: image.placeAt(mapIn(scene, this.#map)),
          lines: [{ points: this.#pointsIn(this.#path, scene, robot), color: path }],
          dots: [{ points: this.scanIn(scene, robot, now), color: scan }],
        };
      },
      cornersIn: (scene) => cornersOf(this.#map?.map ?? null, mapIn(scene, this.#map)),
      close: () => image.close(),
    };
  }

  /** The points that the laser sees, in the frame of a scene. */
  scanIn(scene: Scene, robot: Pose, now: number): readonly Point[] {
    return now - this.#scannedAt > SCAN_MS ? NOTHING : this.#pointsIn(this.#scan, scene, robot);
  }

  #pointsIn(points: Points | null, scene: Scene, robot: Pose): readonly Point[] {
    if (points === null || points.frame === null) return NOTHING;
    const frame = points.frame === "base_link" ? robot : frameIn(scene, [this], points.frame);
    if (frame === null) return NOTHING;
    return points.points.map(([x = 0, y = 0]) => place(frame, { x, y }));
  }
}

/** Where the frame of a map lies in that of a scene; null where the two are not related. */
export function mapIn({ odom }: Scene, map: RobotMap | null): Pose | null {
  const inMap = map?.odom ?? null;
  return odom == null || inMap === null ? null : compose(odom, inverse(inMap));
}
