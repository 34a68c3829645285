import type { Json, JsonSchema } from "../../api/jsonSchema";

/** What a field of a message takes: its type in ROS, with what a form has to know of it. */
export type Shape =
  | BooleanShape
  | IntegerShape
  | FloatShape
  | TextShape
  | NumbersShape
  | BytesShape
  | ListShape
  | MessageShape;

interface BooleanShape {
  kind: "boolean";
}

export interface IntegerShape {
  kind: "integer";
  low: bigint;
  high: bigint;
  /** 64 bits: JSON has it as text where a number would be rounded. */
  wide: boolean;
  /** Its constants; any other number of the type is fine too. */
  choices: readonly Choice[];
}

interface Choice {
  name: string;
  value: number;
  description: string | null;
}

export interface FloatShape {
  kind: "float";
  /** The largest magnitude. */
  limit: number;
  /** Whether it is NaN, not measured, unless somebody sets it. */
  unset: boolean;
}

export interface TextShape {
  kind: "text";
  /** In characters. */
  high: number;
}

/** An array of numbers, written as one text. */
export interface NumbersShape extends Length {
  kind: "numbers";
  item: IntegerShape | FloatShape;
}

/** `uint8[]`: numbers or base64. */
export interface BytesShape extends Length {
  kind: "bytes";
}

/** An array of anything else, item by item. */
export interface ListShape extends Length {
  kind: "list";
  item: Shape;
}

/** How many items there may be; as many as both say where they are the same. */
export interface Length {
  low: number;
  high: number;
}

export interface MessageShape {
  kind: "message";
  /** The full name, such as `sensor_msgs/msg/BatteryState`. */
  type: string;
  description: string | null;
  fields: readonly Field[];
}

export interface Field {
  name: string;
  shape: Shape;
  description: string | null;
  unit: string | null;
  /** What it is when it is left out; undefined where the schema does not tell. */
  initial: Json | undefined;
}

/** The shape of a goal message; messages inside of it that are alike are the same object. */
export function shapeOf(schema: JsonSchema): MessageShape {
  return new Reader(schema.$defs ?? {}).message(schema);
}

class Reader {
  readonly #definitions: Record<string, JsonSchema>;
  readonly #nested = new Map<string, MessageShape>();

  constructor(definitions: Record<string, JsonSchema>) {
    this.#definitions = definitions;
  }

  message(schema: JsonSchema): MessageShape {
    return {
      kind: "message",
      type: schema["x-ros-type"] ?? schema.title ?? "",
      description: schema.description ?? null,
      fields: Object.entries(schema.properties ?? {}).map(([name, property]) => ({
        name,
        shape: this.#shape(property),
        description: property.description ?? null,
        unit: property["x-unit"] ?? null,
        initial: property.default,
      })),
    };
  }

  #shape(schema: JsonSchema): Shape {
    if (schema.$ref !== undefined) return this.#reference(schema.$ref);
    if (schema.anyOf !== undefined) return this.#union(schema.anyOf);
    const types = [schema.type].flat();
    if (types.includes("boolean")) return { kind: "boolean" };
    if (types.includes("integer")) return integer(schema, []);
    if (types.includes("number")) return float(schema);
    if (types.includes("array")) return this.#array(schema);
    if (types.includes("string")) return { kind: "text", high: schema.maxLength ?? Number.POSITIVE_INFINITY };
    throw new Error(`no form for ${JSON.stringify(schema).slice(0, 200)}`);
  }

  #reference(reference: string): MessageShape {
    const name = reference.replace("#/$defs/", "");
    const known = this.#nested.get(name);
    if (known !== undefined) return known;
    const schema = this.#definitions[name];
    if (schema === undefined) throw new Error(`the schema has no ${reference}`);
    const shape = this.message(schema);
    this.#nested.set(name, shape);
    return shape;
  }

  /** A number with its constants, or an array that base64 may stand for. */
  #union(parts: readonly JsonSchema[]): Shape {
    const plain = parts.find((part) => part.type !== undefined && part.enum === undefined);
    if (plain === undefined) throw new Error("no form for a union without a type");
    if (plain.type === "array") return { kind: "bytes", ...lengthOf(plain) };
    return integer(plain, parts);
  }

  #array(schema: JsonSchema): Shape {
    if (schema.items === undefined) throw new Error("no form for an array of no type");
    const item = this.#shape(schema.items);
    const numeric = item.kind === "float" || (item.kind === "integer" && item.choices.length === 0);
    return numeric
      ? { kind: "numbers", item, ...lengthOf(schema) }
      : { kind: "list", item, ...lengthOf(schema) };
  }
}

/** JSON's own numbers lose the last digits of these. */
const WIDE: Record<string, [bigint, bigint]> = {
  int64: [-(2n ** 63n), 2n ** 63n - 1n],
  uint64: [0n, 2n ** 64n - 1n],
};

function integer(schema: JsonSchema, parts: readonly JsonSchema[]): IntegerShape {
  const wide = WIDE[schema.format ?? ""];
  const [low, high] = wide ?? [BigInt(schema.minimum ?? 0), BigInt(schema.maximum ?? 0)];
  const choices = parts.flatMap(({ const: value, title, description }) =>
    typeof value === "number"
      ? [{ name: title ?? String(value), value, description: description ?? null }]
      : [],
  );
  return { kind: "integer", low, high, wide: wide !== undefined, choices };
}

function float(schema: JsonSchema): FloatShape {
  return { kind: "float", limit: schema.maximum ?? Number.MAX_VALUE, unset: schema.default === null };
}

function lengthOf(schema: JsonSchema): Length {
  return { low: schema.minItems ?? 0, high: schema.maxItems ?? Number.POSITIVE_INFINITY };
}

/**
 * What a form holds: numbers as the text that was typed, arrays of numbers as one text, bytes with how they are
 * written, lists and messages as trees of those.
 */
export type Value = boolean | string | Bytes | readonly Value[] | Values;

export interface Values {
  readonly [name: string]: Value;
}

export interface Bytes {
  readonly encoding: "numbers" | "base64";
  readonly text: string;
}

/** Where a value is: names of fields, and numbers of list items. */
export type Path = readonly (string | number)[];

/** A path as the gateway's errors have it: `pose.covariance.3`. */
export function dotted(path: Path): string {
  return path.join(".");
}

/** The tree with another value at the path. */
export function withValue<Tree extends Value>(tree: Tree, path: Path, value: Value): Tree {
  const [step, ...rest] = path;
  if (step === undefined) return value as Tree;
  if (Array.isArray(tree)) {
    return (tree as readonly Value[]).map((item, index) =>
      index === step ? withValue(item, rest, value) : item,
    ) as unknown as Tree;
  }
  const values = tree as Values;
  return { ...values, [step]: withValue(values[step] ?? "", rest, value) } as unknown as Tree;
}
