import type { GatewayEvent, Goal, StopState } from "../api/types";
import { mergeGoals } from "../store/goals";
import { Shown } from "../store/shown";
import {
  type Connection,
  type ConnectionInput,
  initialConnection,
  nextConnection,
} from "../stream/connection";
import { reduceFleet, withStop } from "./reducer";
import { type FleetState, type FleetTopic, type FleetTopics, initialFleet } from "./state";
import type { Alert } from "./types";

/** Holds what is known of all robots, and shows it at most five times a second; a change of the connection at once. */
export class FleetStore {
  #state: FleetState = initialFleet;
  #connection: Connection;
  readonly #shown: Shown<FleetTopics>;
  readonly #now: () => number;

  constructor(now: () => number = Date.now) {
    this.#now = now;
    this.#connection = initialConnection(now());
    this.#shown = new Shown(() => this.#topics(), now);
  }

  readonly onEvent = (event: GatewayEvent): void => {
    const before = this.#state;
    this.#state = reduceFleet(before, event, this.#now());
    if (this.#state === before) return;
    // The page's title counts them, also where nobody sees the rest of the page.
    if (event.type === "alerts") this.#shown.flush();
    else this.#shown.schedule();
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

  /** Takes up what an answer over HTTP says of a robot's stop, the configured one for null: people wait for it. */
  setStop(stop: StopState, robot: string | null = null): void {
    this.#state = withStop(this.#state, robot, stop);
    this.#shown.flush();
  }

  /** Takes up what an answer over HTTP says of an alert: at once, as people wait for it. */
  setAlert(alert: Alert): void {
    const alerts = this.#state.alerts.map((known) => (known.id === alert.id ? alert : known));
    this.#state = { ...this.#state, alerts };
    this.#shown.flush();
  }

  get<T extends FleetTopic>(topic: T): FleetTopics[T] {
    return this.#shown.get(topic);
  }

  subscribe(topic: FleetTopic, listener: () => void): () => void {
    return this.#shown.subscribe(topic, listener);
  }

  /** Now, in the gateway's time (ms). */
  gatewayNow(): number {
    return this.#now() - this.#state.clockSkew;
  }

  #topics(): FleetTopics {
    const { seen: _seen, resumed: _resumed, ...state } = this.#state;
    return { ...state, connection: this.#connection };
  }
}
