import type { components } from "../api/schema.gen";

type Schemas = components["schemas"];

export type Graph = Schemas["Graph"];
export type GraphNode = Schemas["GraphNode"];
export type GraphTopic = Schemas["GraphTopic"];
export type GraphService = Schemas["GraphService"];
export type GraphAction = Schemas["GraphAction"];
/** A publisher or a subscriber; without a node it belongs to a DDS program that is no ROS node. */
export type Endpoint = Schemas["TopicEndpoint"];
/** Null is not known for a depth, and without limit for seconds. */
export type Quality = Schemas["TopicQuality"];
