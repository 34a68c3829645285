import type { EventOf, GatewayEvent, Robot, StopState } from "../api/types";
import { applyFeedback, applyResult, applyStatus, snapshotGoals } from "../store/goals";
import { takeUp } from "../store/streamStore";
import { defaultRobot, isUnder } from "./names";
import { type FleetState, NO_STOP } from "./state";

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
    case "automation":
      return { ...state, decision: event.automation.id };
    default:
      return state;
  }
}

function applySnapshot(state: FleetState, event: EventOf<"snapshot">, now: number): FleetState {
  const { alerts = [] } = event;
  const robots = withRobots(new Map(), event.robots ?? [], []);
  return snapshotGoals(
    {
      ...state,
      resumed: false,
      robots,
      naming: state.naming.updated(robots),
      alerts,
      stop: event.stop,
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
  return { ...state, robots, stop: name === configured ? stop : state.stop };
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
