import type { components } from "./schema.gen.ts";

type Schemas = components["schemas"];

/** A goal on any action, with what is known of it: its messages have whatever fields the action's type has. */
export type Goal = Schemas["Goal"];
export type GoalPage = Schemas["GoalPage"];
/** A goal as streams send it: without tags, notes, and what extensions know of it. */
export type LiveGoal = Schemas["LiveGoal"];
/** A goal of a list; of one that only the stream has sent, these are not known yet. */
export type ListedGoal = LiveGoal & Partial<Omit<Goal, keyof LiveGoal>>;
export type ActionInfo = Schemas["ActionInfo"];
export type GoalHistory = Schemas["GoalHistory"];
/** What a goal's history is made of. */
export type GoalEvent = GoalHistory["events"][number];
/** Where something is in the plane: metres, and radians counter-clockwise from the x axis (REP-103). */
export type Pose = Schemas["Pose"];
export type PoseEvent = Schemas["PoseEvent"];
/** The two things that a robot's docking actions do, each an action with its own goals. */
export type Verb = NonNullable<Goal["verb"]>;
export type GoalStatus = Schemas["GoalStatus"];
export type GoalError = Schemas["GoalError"];
export type Battery = Schemas["Battery"];
/** What `GET /battery` answers: also the age of the state, and other topics with batteries. */
export type BatteryAnswer = Schemas["BatteryAnswer"];
export type BatteryState = Schemas["BatteryState"];
export type Implausible = Schemas["Implausible"];
export type BatteryStateInput = Schemas["BatteryStateInput"];
export type Publisher = Schemas["Publisher"];
export type ActionServer = Schemas["ActionServer"];
export type Twist = Schemas["Twist"];
export type Problem = Schemas["Problem"];
export type StopReport = Schemas["StopReport"];
export type StopState = Schemas["StopState"];
export type Scene = Schemas["Scene"];
export type Footprint = Schemas["Footprint"];
export type Infrared = Schemas["Infrared"];
export type Simulator = Schemas["Simulator"];
export type Calibration = Schemas["Calibration"];
export type DockList = Schemas["DockList"];
export type CalibrationService = Schemas["CalibrationService"];
export type BatteryHistory = Schemas["BatteryHistory"];
export type GatewayEvent = Schemas["Event"];
export type EventOf<Type extends GatewayEvent["type"]> = Extract<GatewayEvent, { type: Type }>;
/** What `include` of a stream can name. */
export type Include = Schemas["Include"];
export type GoalSummary = Schemas["GoalState"];

/** A robot, as `GET /robots` tells. */
export type Robot = Schemas["Robot"];

/** Something that an operator has to know of, as `GET /alerts` tells. */
export type Alert = Schemas["Alert"];
export type Approval = Schemas["Approval"];
