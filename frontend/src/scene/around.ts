import type { DockList, Pose, Scene } from "@dock-gateway/client";
import type { MapColors } from "../api/client";
import { compose, distance, inverse, type Point } from "../store/geometry";
import type { Surroundings } from "../store/surroundings";
import { cornersOf, type DrawnMap, MapImage } from "./mapImage";
import { DOCKED_IN_MARKER } from "./shapes";

export type KnownDock = DockList["docks"][number];

/** A dock of the docking server's database, in the frame that is drawn. */
export interface NamedDock {
  name: string;
  pose: Pose;
}

/** What is around the robot, in the frame that is drawn. */
export interface Seen {
  map: DrawnMap | null;
  scan: readonly Point[];
  path: readonly Point[];
  docks: readonly NamedDock[];
  /** The robot waits for what its laser sees to go away. */
  blocked: boolean;
}

export const UNSEEN: Seen = { map: null, scan: [], path: [], docks: [], blocked: false };

/** A database has the pose of the docked robot: the marker is before it. */
const MARKER_OF_DOCKED = inverse(DOCKED_IN_MARKER);

/** So near to each other, the dock of a scene and one of the database are the same (m). */
const SAME_DOCK_M = 0.3;

/** What is around a robot, for its picture: map, scan, path, and the docks that its docking server knows by name. */
export class Around {
  #docks: readonly KnownDock[] = [];
  #blocked = false;
  /** Whether the view shows the whole map, and not only the robot and its dock. */
  whole = false;
  /** Called where the picture is to be drawn again. */
  onChange: () => void = () => {};
  readonly #image: MapImage;
  readonly #unsubscribe: () => void;

  constructor(
    private readonly data: Surroundings,
    load: (colors: MapColors) => Promise<Blob>,
    colors: MapColors,
  ) {
    this.#image = new MapImage(colors, load, () => this.onChange());
    this.#unsubscribe = data.subscribe(() => this.onChange());
  }

  destroy(): void {
    this.#unsubscribe();
    this.#image.close();
  }

  know(docks: readonly KnownDock[], blocked: boolean): void {
    this.#docks = docks;
    this.#blocked = blocked;
    this.onChange();
  }

  seenIn(scene: Scene, robot: Pose, now: number): Seen {
    const { data } = this;
    this.#image.show(data.map?.map ?? null);
    return {
      map: this.#image.placeIn(scene, data.map),
      scan: data.scanIn(scene, robot, now),
      path: data.pathIn(scene, robot),
      docks: docksIn(scene, this.#docks, data),
      blocked: this.#blocked,
    };
  }

  /** What the view has to show of the map, whose picture may still be on its way; nothing without a map. */
  cornersIn(scene: Scene): Point[] {
    return cornersOf(this.data.map?.map ?? null, this.data.frameIn(scene, "map"));
  }
}

/** The docks whose frames are related to that of a scene. */
function docksIn(scene: Scene, docks: readonly KnownDock[], data: Surroundings): NamedDock[] {
  return docks.flatMap(({ dock_id, frame, pose }) => {
    const origin = frame === null || pose === null ? null : data.frameIn(scene, frame);
    if (origin === null || pose === null) return [];
    return [{ name: dock_id, pose: compose(compose(origin, pose), MARKER_OF_DOCKED) }];
  });
}

/** The dock of the database that the dock of a scene is; null where there is none. */
export function sameDock(dock: Pose, docks: readonly NamedDock[]): NamedDock | null {
  return docks.find(({ pose }) => distance(pose, dock) < SAME_DOCK_M) ?? null;
}
