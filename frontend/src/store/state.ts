import type { ActionServer, BatteryState, Goal, Publisher, Simulator, StopState, Twist } from "../api/types";

/** Ended goals beyond this number are forgotten, the oldest first; running ones never are. */
export const MAX_GOALS = 200;

/** Ids of events that were seen, to know a duplicate by. */
export const MAX_SEEN = 512;

/** Arrival times that a feedback rate is made of. */
export const MAX_ARRIVALS = 32;

/** Stages of one goal that are remembered. */
export const MAX_STAGES = 40;

export interface Battery {
  /** Null until a first message has come. */
  state: BatteryState | null;
  /** When it came, in the gateway's time (ms). */
  receivedAt: number | null;
  /** After this silence (s) it is stale: what the gateway says of it, and what makes a docking server stop the wheels. */
  staleAfterS: number;
}

export interface CmdVel {
  twist: Twist | null;
  /** When it came, in the gateway's time (ms). */
  receivedAt: number | null;
}

/** The goal's id → when its latest feedback messages came, in the gateway's time (ms), oldest first. */
export type Arrivals = ReadonlyMap<string, readonly number[]>;

/** The goal's id → the stages that it was seen in, in order, without those of its end. */
export type Stages = ReadonlyMap<string, readonly string[]>;

/** What is known of goals. */
export interface GoalsState {
  goals: ReadonlyMap<string, Goal>;
  arrivals: Arrivals;
  stages: Stages;
}

/** What is known of one robot. */
export interface State extends GoalsState {
  battery: Battery;
  cmdVel: CmdVel;
  publisher: Publisher | null;
  actionServer: ActionServer | null;
  undockServer: ActionServer | null;
  stop: StopState;
  /** Null where no simulator is on the graph, as far as is known. */
  simulator: Simulator | null;
  /** Feedback messages that the gateway did not send because this page was too slow. */
  dropped: number;
  /** This computer's clock minus the gateway's (ms), as well as is known. */
  clockSkew: number;
  seen: ReadonlySet<string>;
}

export const initialState: State = {
  goals: new Map(),
  arrivals: new Map(),
  stages: new Map(),
  battery: { state: null, receivedAt: null, staleAfterS: Number.POSITIVE_INFINITY },
  cmdVel: { twist: null, receivedAt: null },
  publisher: null,
  actionServer: null,
  undockServer: null,
  stop: { latched: false, since: null, by: null, robots: [] },
  simulator: null,
  dropped: 0,
  clockSkew: 0,
  seen: new Set(),
};
