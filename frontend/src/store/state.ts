import type {
  ActionServer,
  BatteryState,
  EventOf,
  Implausible,
  LiveGoal,
  Publisher,
  Simulator,
  StopState,
  Twist,
} from "@dock-gateway/client";
import type { Stages } from "./stages";

/** Ended goals beyond this number are forgotten, the oldest first; running ones never are. */
export const MAX_GOALS = 200;

/** Ids of events that were seen, to know a duplicate by. */
export const MAX_SEEN = 512;

/** Arrival times that a feedback rate is made of. */
export const MAX_ARRIVALS = 32;

/** Feedback messages that are remembered, to be read. */
export const MAX_FEEDBACK = 12;

interface Battery {
  /** Without values that are not believed; null until a first message has come. */
  state: BatteryState | null;
  /** What of the last message cannot be right. */
  implausible: readonly Implausible[];
  /** When it came, in the gateway's time (ms). */
  receivedAt: number | null;
  /** After this silence (s) it is stale: what the gateway says of it, and what makes a docking server stop the wheels. */
  staleAfterS: number;
  /** A charge (0 to 1) below this is low, as the gateway's alerts have it. */
  lowBelow: number;
}

export interface CmdVel {
  twist: Twist | null;
  /** When it came, in the gateway's time (ms). */
  receivedAt: number | null;
}

/** The goal's id → when its latest feedback messages came, in the gateway's time (ms), oldest first. */
type Arrivals = ReadonlyMap<string, readonly number[]>;

/** What is known of goals. */
export interface GoalsState {
  goals: ReadonlyMap<string, LiveGoal>;
  arrivals: Arrivals;
  stages: Stages;
}

/** What is known from any stream of events. */
export interface StreamState extends GoalsState {
  /** This computer's clock minus the gateway's (ms), as well as is known. */
  clockSkew: number;
  /** Ids of the events that came, to know a duplicate by. */
  seen: ReadonlySet<string>;
}

/** What is known of one robot. */
export interface State extends StreamState {
  battery: Battery;
  cmdVel: CmdVel;
  /** The latest feedback, newest first. */
  feedback: readonly EventOf<"feedback">[];
  publisher: Publisher | null;
  actionServer: ActionServer | null;
  undockServer: ActionServer | null;
  stop: StopState;
  /** Null where no simulator is known to be on the graph. */
  simulator: Simulator | null;
  /** Feedback messages that the gateway did not send because this page was too slow. */
  dropped: number;
  /** Feedback messages that the gateway did not read: too large, or too fast. */
  unread: number;
}

export const initialState: State = {
  goals: new Map(),
  arrivals: new Map(),
  stages: new Map(),
  battery: {
    state: null,
    implausible: [],
    receivedAt: null,
    staleAfterS: Number.POSITIVE_INFINITY,
    lowBelow: 0,
  },
  cmdVel: { twist: null, receivedAt: null },
  feedback: [],
  publisher: null,
  actionServer: null,
  undockServer: null,
  stop: { latched: false, stopped_at: null, by: null, robots: [], persisted: true },
  simulator: null,
  dropped: 0,
  unread: 0,
  clockSkew: 0,
  seen: new Set(),
};
