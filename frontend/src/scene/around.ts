import type { DockList, Pose, Scene } from "@dock-gateway/client";
import { compose, distance, inverse, type Point } from "../store/geometry";
import type { GroundPicture, LayerPainter, Mark, SceneLayer, Scheme } from "../store/layers";
import { DOCKED_IN_MARKER } from "./shapes";

export type KnownDock = DockList["docks"][number];

/** A dock of the docking server's database, in the frame that is drawn. */
export interface NamedDock {
  name: string;
  pose: Pose;
}

/** What is around the robot, in the frame that is drawn: of all layers, the lowest first. */
export interface Seen {
  ground: readonly GroundPicture[];
  lines: readonly Mark[];
  dots: readonly Mark[];
  docks: readonly NamedDock[];
  /** The robot waits for what its laser sees to go away. */
  blocked: boolean;
}

export const UNSEEN: Seen = { ground: [], lines: [], dots: [], docks: [], blocked: false };

/** What is around a robot. */
export interface Surroundings {
  layers: readonly SceneLayer[];
  docks: readonly KnownDock[];
  /** Where the frame of a dock lies in that of a scene; null where the two are not related. */
  frameIn(scene: Scene, frame: string): Pose | null;
  /** The robot waits for what its laser sees. */
  blocked: boolean;
  /** No goal runs on it: a room is shown as a whole then. */
  idle: boolean;
}

/** A ground whose sides are no longer is a room (m). */
const ROOM_M = 30;

/** A database has the pose of the docked robot: the marker is before it. */
const MARKER_OF_DOCKED = inverse(DOCKED_IN_MARKER);

/** So near to each other, the dock of a scene and one of the database are the same (m). */
const SAME_DOCK_M = 0.3;

/** What is around a robot, for its picture: layers, and the docks that its docking server knows by name. */
export class Around {
  /** Whether the view shows the whole ground, and not only the robot and its dock. */
  whole = false;
  /** Called where the picture is to be drawn again. */
  onChange: () => void = () => {};
  readonly #painters: readonly LayerPainter[];
  readonly #unsubscribe: readonly (() => void)[];

  constructor(
    private data: Surroundings,
    scheme: Scheme,
  ) {
    const onChange = () => this.onChange();
    this.#painters = data.layers.map((layer) => layer.paint(scheme, onChange));
    this.#unsubscribe = data.layers.map((layer) => layer.subscribe(onChange));
  }

  destroy(): void {
    for (const unsubscribe of this.#unsubscribe) unsubscribe();
    for (const painter of this.#painters) painter.close();
  }

  /** Takes up other docks. The layers are those that it was made with. */
  know(data: Surroundings): void {
    this.data = data;
    this.onChange();
  }

  seenIn(scene: Scene, robot: Pose, now: number): Seen {
    const views = this.#painters.map((painter) => painter.viewIn(scene, robot, now));
    return {
      ground: views.flatMap(({ ground }) => ground ?? []),
      lines: views.flatMap(({ lines }) => lines),
      dots: views.flatMap(({ dots }) => dots),
      docks: docksIn(scene, this.data),
      blocked: this.data.blocked,
    };
  }

  /** What the view has to show of the ground, whose picture may still be on its way; nothing without one. */
  cornersIn(scene: Scene): Point[] {
    return this.#painters.flatMap((painter) => painter.cornersIn(scene));
  }

  /** What of it the view shows by itself: all of it where that is wished, or where it is a room and no goal runs. */
  shownCornersIn(scene: Scene): Point[] {
    if (!this.whole && !this.data.idle) return [];
    const corners = this.cornersIn(scene);
    return this.whole || isRoom(corners) ? corners : [];
  }
}

/** Whether a ground is a room, which can be seen as a whole. */
function isRoom(corners: readonly Point[]): boolean {
  return corners.every((one) => corners.every((other) => distance(one, other) <= Math.SQRT2 * ROOM_M));
}

/** The docks whose frames are related to that of a scene. */
function docksIn(scene: Scene, { docks, frameIn }: Surroundings): NamedDock[] {
  return docks.flatMap(({ dock_id, frame, pose }) => {
    const origin = frame === null || pose === null ? null : frameIn(scene, frame);
    if (origin === null || pose === null) return [];
    return [{ name: dock_id, pose: compose(compose(origin, pose), MARKER_OF_DOCKED) }];
  });
}

/** The dock of the database that the dock of a scene is; null where there is none. */
export function sameDock(dock: Pose, docks: readonly NamedDock[]): NamedDock | null {
  return docks.find(({ pose }) => distance(pose, dock) < SAME_DOCK_M) ?? null;
}
