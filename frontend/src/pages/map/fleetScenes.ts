import type { GatewayEvent, Scene } from "../../api/types";
import type { StreamHandlers } from "../../stream/stream";

/** By robot, the frame that its pose is given in. */
export type Frames = ReadonlyMap<string, Scene["frame"]>;

/** The scenes of all robots as they come. */
export class FleetScenes implements StreamHandlers {
  latest: Readonly<Record<string, Scene>> = {};
  /** When the latest came (ms, on the clock of `performance.now()`). */
  arrivedAt = Number.NEGATIVE_INFINITY;
  /** The same map until a robot appears, disappears or changes its frame; null before the first event. */
  frames: Frames | null = null;
  readonly #listeners = new Set<() => void>();

  readonly onEvent = (event: GatewayEvent): void => {
    if (event.type !== "scenes") return;
    this.latest = event.scenes;
    this.arrivedAt = performance.now();
    const frames = new Map(Object.entries(event.scenes).map(([robot, { frame }]) => [robot, frame]));
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
