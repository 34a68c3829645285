import type { EventOf, GatewayEvent, Goal, Simulator, StopState } from "../api/types";
import {
  type Connection,
  type ConnectionInput,
  initialConnection,
  nextConnection,
} from "../stream/connection";
import { courseLister, type GoalCourse, mergeGoals } from "./goals";
import { reduce } from "./reducer";
import { Shown } from "./shown";
import { withPast } from "./stages";
import { initialState, type State } from "./state";

/** What is shown of a robot, each part with subscribers of its own. */
export interface Topics extends Omit<State, "seen"> {
  /** The goals without their feedback, newest first; the same list for as long as only feedback comes. */
  courses: readonly GoalCourse[];
  connection: Connection;
}

export type Topic = keyof Topics;

/** Holds what is known of one robot, and shows it at most five times a second; a change of the connection at once. */
export class Store {
  #state: State = initialState;
  #connection: Connection;
  readonly #shown: Shown<Topics>;
  readonly #courses = courseLister();
  readonly #batteryListeners = new Set<(event: EventOf<"battery">) => void>();
  readonly #sceneListeners = new Set<(event: EventOf<"scene">) => void>();
  readonly #now: () => number;

  constructor(now: () => number = Date.now) {
    this.#now = now;
    this.#connection = initialConnection(now());
    this.#shown = new Shown(() => this.#topics(), now);
  }

  readonly onEvent = (event: GatewayEvent): void => {
    if (event.type === "scene") {
      for (const listener of this.#sceneListeners) listener(event);
      return;
    }
    const before = this.#state;
    this.#state = reduce(before, event, this.#now());
    if (this.#state === before) return;
    if (event.type === "battery") for (const listener of this.#batteryListeners) listener(event);
    this.#shown.schedule();
  };

  readonly onConnection = (input: ConnectionInput): void => {
    const next = nextConnection(this.#connection, input, this.#now());
    if (next === this.#connection) return;
    this.#connection = next;
    this.#shown.flush();
  };

  /** Takes up goals from an answer over HTTP. */
  addGoals(goals: readonly Goal[]): void {
    this.#state = mergeGoals(this.#state, goals);
    this.#shown.schedule();
  }

  /** Takes up what a goal's history tells of its way. */
  setWay(goalId: string, statuses: readonly { time: string; stage: string | null }[]): void {
    this.#state = { ...this.#state, stages: withPast(this.#state.stages, goalId, statuses) };
    this.#shown.schedule();
  }

  /** Takes up what an answer over HTTP says of the simulator; null where there is none. */
  readonly setSimulator = (simulator: Simulator | null): void => {
    this.#state = { ...this.#state, simulator };
    this.#shown.schedule();
  };

  /** Takes up what an answer over HTTP says of the stop: at once, as people wait for it. */
  setStop(stop: StopState): void {
    this.#state = { ...this.#state, stop };
    this.#shown.flush();
  }

  get<T extends Topic>(topic: T): Topics[T] {
    return this.#shown.get(topic);
  }

  subscribe(topic: Topic, listener: () => void): () => void {
    return this.#shown.subscribe(topic, listener);
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

  /** Now, in the gateway's time (ms): what its timestamps are compared with. */
  gatewayNow(): number {
    return this.#now() - this.#state.clockSkew;
  }

  #topics(): Topics {
    const { seen: _seen, ...state } = this.#state;
    return { ...state, courses: this.#courses(state.goals), connection: this.#connection };
  }
}
