import type { ActionServer, BatteryState, Goal, StopState } from "../api/types";

export type GoalSummary = Omit<Goal, "goal" | "feedback" | "result">;

/** A robot, as `GET /robots` tells. */
export interface Robot {
  name: string;
  default: boolean;
  /** Null where nobody knows. */
  docked: boolean | null;
  simulated: boolean;
  battery: { state: BatteryState | null; received_at: string | null; stale: boolean; stale_after_s: number };
  battery_topic: string;
  battery_publisher: { active: boolean; rate_hz: number | null };
  stop: StopState;
  dock: ActionServer | null;
  undock: ActionServer | null;
  goals: GoalSummary[];
  last_goal: GoalSummary | null;
}

/** Something that an operator has to know of, as `GET /alerts` tells. */
export interface Alert {
  id: string;
  kind: string;
  robot: string;
  severity: "critical" | "warning";
  since: string;
  title: string;
  detail: string;
  goal_id: string | null;
  acknowledged: { by: string; at: string } | null;
}

export interface RobotsEvent {
  type: "robots";
  time: string;
  robots: Robot[];
  gone: string[];
}

export interface AlertsEvent {
  type: "alerts";
  time: string;
  alerts: Alert[];
}

/** What the snapshot of a stream with `include=robots` has besides. */
export interface FleetSnapshot {
  robots?: Robot[];
  alerts?: Alert[];
}
