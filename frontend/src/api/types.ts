import type { components } from "./schema.gen";

type Schemas = components["schemas"];

export type Goal = Schemas["Goal"];
export type GoalPage = Schemas["GoalPage"];
export type GoalStatus = Schemas["GoalStatus"];
export type BatteryState = Schemas["BatteryState"];
export type BatteryStateInput = Schemas["BatteryStateInput"];
export type Publisher = Schemas["Publisher"];
export type ActionServer = Schemas["ActionServer"];
export type Twist = Schemas["Twist"];
export type Problem = Schemas["Problem"];
export type StopReport = Schemas["StopReport"];

// The generator puts the schema's name in the place of `type`; on the wire it is the event's own.
type Tagged<Type extends string, Schema> = Omit<Schema, "type"> & { type: Type };

export type GatewayEvent =
  | Tagged<"snapshot", Schemas["SnapshotEvent"]>
  | Tagged<"status", Schemas["StatusEvent"]>
  | Tagged<"feedback", Schemas["FeedbackEvent"]>
  | Tagged<"result", Schemas["ResultEvent"]>
  | Tagged<"battery", Schemas["BatteryEvent"]>
  | Tagged<"cmd_vel", Schemas["CmdVelEvent"]>
  | Tagged<"battery_publisher", Schemas["PublisherEvent"]>
  | Tagged<"action_server", Schemas["ActionServerEvent"]>
  | Tagged<"heartbeat", Schemas["HeartbeatEvent"]>
  | Tagged<"dropped", Schemas["DroppedEvent"]>
  | Tagged<"closing", Schemas["ClosingEvent"]>;

export type EventOf<Type extends GatewayEvent["type"]> = Extract<GatewayEvent, { type: Type }>;
