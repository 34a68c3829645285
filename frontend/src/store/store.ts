import type { EventOf, GatewayEvent, Simulator, StopState } from "@dock-gateway/client";
import { steadyNow } from "../clock/beat";
import type { Connection } from "../stream/connection";
import { courseLister, type GoalCourse } from "./goals";
import { reduce } from "./reducer";
import { type PastOfWay, withPast } from "./stages";
import { initialState, type State } from "./state";
import { StreamStore } from "./streamStore";

/** What is shown of a robot, each part with subscribers of its own. */
export interface Topics extends Omit<State, "seen"> {
  /** The goals without their feedback, newest first; the same list for as long as only feedback comes. */
  courses: readonly GoalCourse[];
  connection: Connection;
}

export type Topic = keyof Topics;

/** Holds what is known of one robot. */
export class Store extends StreamStore<State, Topics> {
  readonly #batteryListeners = new Set<(event: EventOf<"battery">) => void>();
  readonly #sceneListeners = new Set<(event: EventOf<"scene">) => void>();

  constructor(now: () => number = steadyNow) {
    const courses = courseLister();
    const topicsOf = ({ seen: _seen, ...state }: State, connection: Connection): Topics => ({
      ...state,
      courses: courses(state.goals),
      connection,
    });
    super(initialState, reduce, topicsOf, now);
  }

  readonly onEvent = (event: GatewayEvent): void => {
    if (event.type === "scene") {
      for (const listener of this.#sceneListeners) listener(event);
      return;
    }
    if (!this.take(event)) return;
    if (event.type === "battery") for (const listener of this.#batteryListeners) listener(event);
    this.shown.schedule();
  };

  /** Takes up what a goal's history tells of its way. */
  setWay(goalId: string, past: PastOfWay): void {
    this.state = { ...this.state, stages: withPast(this.state.stages, goalId, past) };
    this.shown.schedule();
  }

  /** Takes up what an answer over HTTP says of the simulator, null where there is none: at once, as what is asked before a robot moves depends on it. */
  readonly setSimulator = (simulator: Simulator | null): void => {
    this.state = { ...this.state, simulator };
    this.shown.flush();
  };

  /** Takes up what an answer over HTTP says of the stop: at once, as people wait for it. */
  setStop(stop: StopState): void {
    this.state = { ...this.state, stop };
    this.shown.flush();
  }

  /** Every battery message as it comes, unthrottled: for the plot's buffer. */
  onBattery(listener: (event: EventOf<"battery">) => void): () => void {
    this.#batteryListeners.add(listener);
    return () => this.#batteryListeners.delete(listener);
  }

  /** Every scene as it comes: for the picture, which is drawn outside of React. */
  onScene(listener: (event: EventOf<"scene">) => void): () => void {
    this.#sceneListeners.add(listener);
    return () => this.#sceneListeners.delete(listener);
  }
}
