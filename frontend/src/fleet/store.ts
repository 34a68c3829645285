import type { Alert, Approval, EventOf, GatewayEvent, Robot, StopState } from "@dock-gateway/client";
import { steadyNow } from "../clock/beat";
import { applyFeedback, applyResult, applyStatus, snapshotGoals } from "../store/goals";
import type { StreamState } from "../store/state";
import { StreamStore, takeUp } from "../store/streamStore";
import type { Connection } from "../stream/connection";
import { defaultRobot, isUnder, Naming } from "./names";

function topicsOf(
  { seen: _seen, resumed: _resumed, ...state }: FleetState,
  connection: Connection,
): FleetTopics {
  return { ...state, connection };
}

/** Holds what is known of all robots. */
export class FleetStore extends StreamStore<FleetState, FleetTopics> {
  readonly #listeners = new Set<(event: GatewayEvent) => void>();

  constructor(now: () => number = steadyNow) {
    super(initialFleet, reduceFleet, topicsOf, now);
  }

  /** Calls a listener with each event, for what is no topic here: events of extensions. */
  onEvents(listener: (event: GatewayEvent) => void): () => void {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }

  readonly onEvent = (event: GatewayEvent): void => {
    for (const listener of this.#listeners) listener(event);
    if (!this.take(event)) return;
    // The page's title counts them, also while the page is hidden.
    if (event.type === "alerts") this.shown.flush();
    else this.shown.schedule();
  };

  /** Takes up what an answer over HTTP says of a robot's stop: people wait for it. */
  setStop(stop: StopState, robot: string): void {
    this.state = withStop(this.state, robot, stop);
    this.shown.flush();
  }

  /** Takes up that an agent's goal was answered: at once, as people wait for it. */
  setAnswered(approvalId: string): void {
    const approvals = this.state.approvals.filter(({ id }) => id !== approvalId);
    this.state = { ...this.state, approvals };
    this.shown.flush();
  }

  /** Takes up what an answer over HTTP says of an alert: at once, as people wait for it. */
  setAlert(alert: Alert): void {
    const alerts = this.state.alerts.map((known) => (known.id === alert.id ? alert : known));
    this.state = { ...this.state, alerts };
    this.shown.flush();
  }
}

/** What is known of all robots and of the goals on every action. */
interface FleetState extends StreamState {
  /** The robots by name. */
  robots: ReadonlyMap<string, Robot>;
  /** Their names and groups: another object only when one of these changes. */
  naming: Naming;
  alerts: readonly Alert[];
  /** Agents' goals that wait until somebody allows them, oldest first. */
  approvals: readonly Approval[];
  /** That of the robot that the gateway is configured for. */
  stop: StopState;
  /** The stream goes on after an event, and what is not replayed has still to come. */
  resumed: boolean;
}

export interface FleetTopics extends Omit<FleetState, "seen" | "resumed"> {
  connection: Connection;
}

export type FleetTopic = keyof FleetTopics;

const NO_STOP: StopState = { latched: false, stopped_at: null, by: null, robots: [], persisted: true };

export const initialFleet: FleetState = {
  goals: new Map(),
  arrivals: new Map(),
  stages: new Map(),
  robots: new Map(),
  naming: new Naming([]),
  alerts: [],
  approvals: [],
  stop: NO_STOP,
  clockSkew: 0,
  seen: new Set(),
  resumed: false,
};

/** The state after an event. Pure; the same object where the event changes nothing. */
export function reduceFleet(state: FleetState, event: GatewayEvent, now: number): FleetState {
  return takeUp(state, event, now, apply);
}

function apply(state: FleetState, event: GatewayEvent, now: number): FleetState {
  switch (event.type) {
    case "snapshot":
      return applySnapshot(state, event, now);
    case "status":
      return applyStatus(state, event);
    case "feedback":
      return applyFeedback(state, event);
    case "result":
      return applyResult(state, event);
    case "stop":
      return withStop(state, event.robot, event.stop);
    case "resumed":
      return { ...state, resumed: true };
    case "robots": {
      // The first after a resume is all of them.
      const known: FleetState["robots"] = state.resumed ? new Map() : state.robots;
      const robots = withRobots(known, event.robots, event.gone);
      return { ...state, resumed: false, robots, naming: state.naming.updated(robots) };
    }
    case "alerts":
      return { ...state, alerts: event.alerts };
    case "approvals":
      return { ...state, approvals: event.approvals };
    default:
      return state;
  }
}

function applySnapshot(state: FleetState, event: EventOf<"snapshot">, now: number): FleetState {
  const { alerts = [], approvals = [] } = event;
  const robots = withRobots(new Map(), event.robots ?? [], []);
  return snapshotGoals(
    {
      ...state,
      resumed: false,
      robots,
      naming: state.naming.updated(robots),
      alerts,
      approvals,
      stop: event.stop ?? NO_STOP,
      clockSkew: now - Date.parse(event.time),
    },
    null,
    event.goals,
  );
}

/**
 * Takes up the stop of a robot, the configured one for null, and what it says of the robots in namespaces below. Of
 * those the gateway tells only later.
 */
export function withStop(state: FleetState, robot: string | null, stop: StopState): FleetState {
  const configured = defaultRobot(state.robots);
  const name = robot ?? configured;
  const robots = new Map(state.robots);
  for (const known of state.robots.values()) {
    if (!isUnder(known.name, name)) continue;
    const latched = stop.robots.includes(known.name);
    if (known.name === name) robots.set(name, { ...known, stop });
    else if (latched !== known.stop.latched)
      robots.set(known.name, { ...known, stop: { ...(latched ? stop : NO_STOP), robots: [] } });
  }
  const own = robots.get(configured)?.stop ?? state.stop;
  return { ...state, robots, stop: name === configured ? stop : own };
}

function withRobots(
  known: ReadonlyMap<string, Robot>,
  changed: readonly Robot[],
  gone: readonly string[],
): ReadonlyMap<string, Robot> {
  const robots = new Map(known);
  for (const robot of changed) robots.set(robot.name, robot);
  for (const name of gone) robots.delete(name);
  return robots;
}
