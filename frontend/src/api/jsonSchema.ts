/** What the gateway's JSON Schemas (draft 2020-12) say of a ROS message: the part that this page reads. */
export interface JsonSchema {
  $ref?: string;
  $defs?: Record<string, JsonSchema>;
  type?: string | readonly string[];
  title?: string;
  description?: string;
  properties?: Record<string, JsonSchema>;
  items?: JsonSchema;
  anyOf?: readonly JsonSchema[];
  const?: Json;
  enum?: readonly Json[];
  default?: Json;
  format?: string;
  minimum?: number;
  maximum?: number;
  maxLength?: number;
  minItems?: number;
  maxItems?: number;
  contentEncoding?: string;
  "x-ros-type"?: string;
  "x-unit"?: string;
  "x-constants"?: Record<string, number | string>;
}

/** A place in a schema; undefined where nothing is known of it. */
export interface SchemaNode {
  schema: JsonSchema;
  /** The whole, whose `$defs` the references point to. */
  root: JsonSchema;
}

const DEFS = "#/$defs/";

export function rootNode(schema: JsonSchema | undefined): SchemaNode | undefined {
  return schema && resolve(schema, schema);
}

/** The schema of a field of a message. */
export function fieldNode(node: SchemaNode | undefined, name: string): SchemaNode | undefined {
  const field = node?.schema.properties?.[name];
  return field && node ? resolve(field, node.root) : undefined;
}

/** The schema of the items of an array; also where something else is taken in its stead, as base64 for bytes. */
export function itemNode(node: SchemaNode | undefined): SchemaNode | undefined {
  if (node === undefined) return undefined;
  const { items, anyOf = [] } = node.schema;
  const found = items ?? anyOf.find((choice) => choice.items !== undefined)?.items;
  if (found === undefined) return undefined;
  const item = resolve(found, node.root);
  const unit = node.schema["x-unit"];
  return unit === undefined ? item : { ...item, schema: { "x-unit": unit, ...item.schema } };
}

/** Fields next to a reference (a description) override those that it points to. */
function resolve(schema: JsonSchema, root: JsonSchema): SchemaNode {
  const { $ref, ...beside } = schema;
  if ($ref === undefined) return { schema, root };
  return { schema: { ...root.$defs?.[$ref.slice(DEFS.length)], ...beside }, root };
}

/** The name of the constant that a value has, as in `CHARGING` for 1. */
export function constantName(node: SchemaNode | undefined, value: unknown): string | null {
  const constants = Object.entries(node?.schema["x-constants"] ?? {});
  return constants.find(([, constant]) => constant === value)?.[0] ?? null;
}

export function unitOf(node: SchemaNode | undefined): string | null {
  return node?.schema["x-unit"] ?? null;
}

export function descriptionOf(node: SchemaNode | undefined): string | null {
  return node?.schema.description ?? null;
}

/** `sensor_msgs/BatteryState`, as `ros2` prints types; null where it is no message. */
export function typeOf(node: SchemaNode | undefined): string | null {
  return node?.schema["x-ros-type"]?.replace("/msg/", "/") ?? null;
}

export type Json = null | boolean | number | string | readonly Json[] | JsonObject;

export interface JsonObject {
  readonly [name: string]: Json;
}

export function isObject(json: unknown): json is JsonObject {
  return typeof json === "object" && json !== null && !Array.isArray(json);
}

export function isArray(json: Json | undefined): json is readonly Json[] {
  return Array.isArray(json);
}

/** Whether two documents are the same; the order of names does not count. */
export function same(a: Json | undefined, b: Json | undefined): boolean {
  if (isArray(a) && isArray(b))
    return a.length === b.length && a.every((item, index) => same(item, b[index]));
  if (isObject(a) && isObject(b)) {
    const names = Object.keys(a);
    return (
      names.length === Object.keys(b).length && names.every((name) => name in b && same(a[name], b[name]))
    );
  }
  return a === b;
}
