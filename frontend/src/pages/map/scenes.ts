import type { GatewayEvent, Include, Scene, StreamHandlers } from "@dock-gateway/client";
import { useState } from "react";
import { useExtensions } from "../../extension/context";
import { layersOf } from "../../extension/extension";
import { useFleet } from "../../fleet/context";
import { type FleetLayer, type FleetPoses, SHARED_FRAME } from "../../store/layers";

/** The frame of each robot's pose, by robot. */
export type Frames = ReadonlyMap<string, Scene["frame"]>;

/** The scenes of all robots as they come, with what layers know of where they are. */
export class FleetScenes implements StreamHandlers {
  /** The pose of each robot, in the shared frame where that is known. */
  latest: FleetPoses = {};
  /** When the latest came (ms, on the clock of `performance.now()`). */
  arrivedAt = Number.NEGATIVE_INFINITY;
  /** The same map until a robot appears, disappears or changes its frame; null before the first event. */
  frames: Frames | null = null;
  #sent: FleetPoses = {};
  readonly #listeners = new Set<() => void>();

  /**
   * @param layers The lowest first.
   * @param topics What they read of the stream.
   * @param nameOf The name of a robot on this page.
   */
  constructor(
    readonly layers: readonly FleetLayer[],
    topics: readonly Include[] = [],
    private readonly nameOf: (robot: string) => string = (robot) => robot,
  ) {
    this.query = { include: ["scenes", ...topics].join(","), feedback: "false" };
  }

  /** What to ask a stream for. */
  readonly query: { include: string; feedback: string };

  /** The name of the frame that is drawn. */
  get frame(): string {
    const shared = Object.values(this.#sent).some(({ frame }) => frame === SHARED_FRAME);
    const ground = this.layers.find(({ frame }) => frame !== null);
    return shared ? SHARED_FRAME : (ground?.frame ?? SHARED_FRAME);
  }

  /** Whether a layer has something below all robots. */
  get hasGround(): boolean {
    return this.layers.some(({ frame }) => frame !== null);
  }

  readonly onEvent = (event: GatewayEvent): void => {
    const { nameOf } = this;
    const isScenes = event.type === "scenes";
    if (isScenes) {
      this.#sent = Object.fromEntries(
        Object.entries(event.scenes).map(([robot, scene]) => [nameOf(robot), scene]),
      );
      this.arrivedAt = performance.now();
    } else if (this.layers.filter((layer) => layer.onEvent(event, nameOf)).length === 0) return;
    this.latest = this.layers.reduce((scenes, layer) => layer.arrange(scenes), this.#sent);
    if (!isScenes && this.frames === null) return;
    const frames = new Map(Object.entries(this.latest).map(([robot, { frame }]) => [robot, frame]));
    if (this.frames === null || !isSame(this.frames, frames)) this.frames = frames;
    for (const listener of this.#listeners) listener();
  };

  /** The connection is that of all pages. */
  readonly onConnection = (): void => {};

  /** Calls `listener` for every event, until the returned function is called. */
  readonly subscribe = (listener: () => void): (() => void) => {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  };
}

function isSame(one: Frames, other: Frames): boolean {
  return one.size === other.size && [...one].every(([robot, frame]) => other.get(robot) === frame);
}

/** The scenes of all robots, for as long as a page is shown. @param nameOf The name of a robot on this page. */
export function useFleetScenes(nameOf?: (robot: string) => string): FleetScenes {
  const drawn = layersOf(useExtensions());
  const { httpOf } = useFleet();
  const [scenes] = useState(
    () =>
      new FleetScenes(
        drawn.map((each) => each.ofFleet(httpOf)),
        drawn.flatMap(({ fleetTopics }) => fleetTopics),
        nameOf,
      ),
  );
  return scenes;
}
