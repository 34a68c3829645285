import type { components } from "../api/schema.gen";

type Schemas = components["schemas"];

export type GoalSummary = Schemas["GoalState"];
/** A robot, as `GET /robots` tells. */
export type Robot = Schemas["Robot"];
/** Something that an operator has to know of, as `GET /alerts` tells. */
export type Alert = Schemas["Alert"];
