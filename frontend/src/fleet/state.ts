import type { Alert, Robot, StopState } from "../api/types";
import type { StreamState } from "../store/state";
import type { Connection } from "../stream/connection";
import { Naming } from "./names";

/** What is known of all robots and of the goals on every action. */
export interface FleetState extends StreamState {
  /** By name. */
  robots: ReadonlyMap<string, Robot>;
  /** Their names and groups: another object only when one of these changes. */
  naming: Naming;
  alerts: readonly Alert[];
  /** The id of the last decision of automatic docking that the stream told of; null before the first. */
  decision: string | null;
  /** That of the robot that the gateway is configured for. */
  stop: StopState;
  /** The stream goes on after an event, and what is not replayed has still to come. */
  resumed: boolean;
}

export interface FleetTopics extends Omit<FleetState, "seen" | "resumed"> {
  connection: Connection;
}

export type FleetTopic = keyof FleetTopics;

export const NO_STOP: StopState = { latched: false, since: null, by: null, robots: [], persisted: true };

export const initialFleet: FleetState = {
  goals: new Map(),
  arrivals: new Map(),
  stages: new Map(),
  robots: new Map(),
  naming: new Naming([]),
  alerts: [],
  decision: null,
  stop: NO_STOP,
  clockSkew: 0,
  seen: new Set(),
  resumed: false,
};
