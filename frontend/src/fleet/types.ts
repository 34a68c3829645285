import type { components } from "../api/schema.gen";
import type { EventOf } from "../api/types";

type Schemas = components["schemas"];

export type GoalSummary = Schemas["GoalState"];
/** A robot, as `GET /robots` tells. */
export type Robot = Schemas["Robot"];

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

export type RobotsEvent = EventOf<"robots">;

export interface AlertsEvent {
  type: "alerts";
  time: string;
  alerts: Alert[];
}

/** What the snapshot of a stream with `include=robots` has besides. */
export interface FleetSnapshot {
  alerts?: Alert[];
}
