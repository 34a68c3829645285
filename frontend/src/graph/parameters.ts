import type { ParameterInfo } from "../api/calls";
import { isArray, type Json, type JsonObject, type JsonSchema } from "../api/jsonSchema";

const INTEGER: JsonSchema = { type: "integer", format: "int64" };
const DOUBLE: JsonSchema = { type: "number" };
const TEXT: JsonSchema = { type: "string" };
const FLAG: JsonSchema = { type: "boolean" };
const BYTE: JsonSchema = { type: "integer", minimum: 0, maximum: 255 };

/** What a parameter of each type takes; a type that is not here is not set by a form. */
const SCHEMAS: Record<string, JsonSchema> = {
  boolean: FLAG,
  integer: INTEGER,
  double: DOUBLE,
  string: TEXT,
  "byte array": { type: "array", items: BYTE },
  "boolean array": { type: "array", items: FLAG },
  "integer array": { type: "array", items: INTEGER },
  "double array": { type: "array", items: DOUBLE },
  "string array": { type: "array", items: TEXT },
};

/** Whether a form can set a parameter. */
export function isSettable({ read_only, type }: ParameterInfo): boolean {
  return !read_only && type in SCHEMAS;
}

/** The parameters of a node as a message, so that they have a form. */
export function parametersSchema(parameters: readonly ParameterInfo[]): JsonSchema {
  return {
    type: "object",
    properties: Object.fromEntries(
      parameters.map((parameter) => [
        parameter.name,
        { ...SCHEMAS[parameter.type], description: describe(parameter), default: parameter.value as Json },
      ]),
    ),
  };
}

/** What the node says of a parameter, with its type and range. */
export function describe({ description, constraints, range, type }: ParameterInfo): string {
  const limits = range === null ? "" : `, ${range.minimum} to ${range.maximum}${steps(range.step)}`;
  return [`${type}${limits}`, description, constraints].filter((part) => part !== "").join("\n");
}

function steps(step: Json): string {
  return Number(step) === 0 ? "" : ` in steps of ${step}`;
}

/** The values of a form that differ from those of the node. */
export function changesOf(parameters: readonly ParameterInfo[], message: JsonObject): JsonObject {
  const before = new Map(parameters.map(({ name, value }) => [name, JSON.stringify(value)]));
  return Object.fromEntries(
    Object.entries(message).filter(([name, value]) => JSON.stringify(value) !== before.get(name)),
  );
}

/** A value on one line. */
export function valueText(value: unknown): string {
  if (value === null) return "not set, or NaN";
  if (typeof value === "string") return value === "" ? "(empty)" : value;
  return isArray(value as Json) ? JSON.stringify(value).slice(0, 300) : String(value);
}
