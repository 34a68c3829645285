import type { Battery, EventOf, GatewayEvent } from "@dock-gateway/client";
import { believed } from "./batterySeries";
import { applyFeedback, applyResult, applyStatus, snapshotGoals } from "./goals";
import { initialState, MAX_FEEDBACK, type State } from "./state";
import { takeUp } from "./streamStore";

/**
 * The state after an event. Pure; returns the same object where the event changes nothing, and keeps every part that it
 * does not touch. The page is about one docking action and its undocking action, those that the snapshot or a later event
 * names: events of the other actions on the graph, whose messages have other fields, change nothing.
 *
 * @param now This computer's time when the event came (ms).
 */
export function reduce(state: State, event: GatewayEvent, now: number): State {
  return isOfAnotherAction(state, event) ? state : takeUp(state, event, now, applyEvent);
}

function isOfAnotherAction(state: State, event: GatewayEvent): boolean {
  if (event.type === "action_server") return !actionsOf(state).includes(event.action_server.action_name);
  if (!("action_name" in event) || actionsOf(state).includes(event.action_name)) return false;
  return "goal_id" in event && !state.goals.has(event.goal_id);
}

function actionsOf({ actionServer, undockServer }: Pick<State, "actionServer" | "undockServer">): string[] {
  return [actionServer, undockServer].flatMap((server) => (server === null ? [] : [server.action_name]));
}

function applyEvent(state: State, event: GatewayEvent, now: number): State {
  switch (event.type) {
    case "snapshot":
      return applySnapshot(state, event, now);
    case "status":
      return applyStatus(state, event);
    case "feedback":
      return applyFeedback(
        { ...state, feedback: [event, ...state.feedback.slice(0, MAX_FEEDBACK - 1)] },
        event,
      );
    case "result":
      return applyResult(state, event);
    case "battery":
      return { ...state, battery: batteryOf(event.battery) };
    case "cmd_vel":
      return { ...state, cmdVel: { twist: event.cmd_vel, receivedAt: Date.parse(event.time) } };
    case "battery_publisher":
      return { ...state, publisher: event.battery_publisher };
    case "action_server":
      return event.action_server.action_name === state.undockServer?.action_name
        ? { ...state, undockServer: event.action_server }
        : { ...state, actionServer: event.action_server };
    case "docking":
      return { ...state, actionServer: event.docking.dock, undockServer: event.docking.undock };
    case "stop":
      return { ...state, stop: event.stop };
    case "simulator":
      return { ...state, simulator: event.simulator.available ? event.simulator : null };
    case "dropped":
      return { ...state, dropped: state.dropped + event.count };
    case "feedback_dropped":
      return { ...state, unread: state.unread + event.count };
    default:
      return state;
  }
}

function applySnapshot(state: State, event: EventOf<"snapshot">, now: number): State {
  const { docking, battery, battery_publisher, simulator } = event;
  const servers = { actionServer: docking?.dock ?? null, undockServer: docking?.undock ?? null };
  return snapshotGoals(
    {
      ...state,
      battery: battery === undefined ? initialState.battery : batteryOf(battery),
      cmdVel: { twist: null, receivedAt: null },
      publisher: battery_publisher ?? null,
      ...servers,
      stop: event.stop ?? initialState.stop,
      simulator: simulator?.available ? simulator : null,
      clockSkew: now - Date.parse(event.time),
    },
    actionsOf(servers),
    event.goals,
  );
}

function batteryOf(battery: Battery): State["battery"] {
  const { implausible, received_at, stale_after_s, low_below } = battery;
  return {
    state: believed(battery),
    implausible,
    receivedAt: received_at === null ? null : Date.parse(received_at),
    staleAfterS: stale_after_s,
    lowBelow: low_below,
  };
}
