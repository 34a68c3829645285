import type { IntegerShape, MessageShape, Shape } from "../../src/actions/form/shapes";
import type { Json, JsonSchema } from "../../src/api/jsonSchema";

/** Numbers that look random and are the same each time (mulberry32). */
export class Random {
  #state: number;

  constructor(seed: number) {
    this.#state = seed;
  }

  /** From 0 to 1. */
  next(): number {
    this.#state = (this.#state + 0x6d2b79f5) | 0;
    let mixed = Math.imul(this.#state ^ (this.#state >>> 15), 1 | this.#state);
    mixed = (mixed + Math.imul(mixed ^ (mixed >>> 7), 61 | mixed)) ^ mixed;
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 2 ** 32;
  }

  below(limit: number): number {
    return Math.floor(this.next() * limit);
  }

  of<Item>(items: readonly Item[]): Item {
    return items[this.below(items.length)] as Item;
  }
}

const CHARACTERS = ["a", "Z", " ", "\n", '"', "'", "\\", "é", "ß", "🤖", ","];

/** A message that the shape takes: some of its fields, each in one of its forms. */
export function randomMessage(shape: MessageShape, random: Random): Record<string, Json> {
  const fields = shape.fields.filter(() => random.next() < 0.4);
  return Object.fromEntries(fields.map((field) => [field.name, randomJson(field.shape, random)]));
}

function randomJson(shape: Shape, random: Random): Json {
  const many = (low: number, high: number) => low + random.below(Math.min(high, low + 4) - low + 1);
  const array = (length: number, item: () => Json) => Array.from({ length }, item);
  switch (shape.kind) {
    case "boolean":
      return random.next() < 0.5;
    case "integer":
      return randomInteger(shape, random);
    case "float":
      return random.of([null, 0, -0.25, 1e-7, 3.25e38, 2.16, -12]);
    case "text":
      return array(many(0, shape.high), () => random.of(CHARACTERS)).join("");
    case "numbers":
      return array(many(shape.low, shape.high), () => randomJson(shape.item, random));
    case "bytes": {
      const bytes = array(many(shape.low, shape.high), () => random.below(256)) as number[];
      return random.next() < 0.5 ? bytes : btoa(String.fromCharCode(...bytes));
    }
    case "list":
      return array(many(shape.low, shape.high), () => randomJson(shape.item, random));
    case "message":
      return randomMessage(shape, random);
  }
}

function randomInteger({ low, high, wide, choices }: IntegerShape, random: Random): Json {
  if (choices.length > 0 && random.next() < 0.7) {
    const choice = random.of(choices);
    return random.next() < 0.5 ? choice.name : choice.value;
  }
  const number = random.of([low, high, low + 1n, high - 1n, BigInt(random.below(100))]);
  return wide && !Number.isSafeInteger(Number(number)) ? String(number) : Number(number);
}

/** Whether a JSON Schema takes a document; of the words that the gateway's schemas use. */
export function takes(schema: JsonSchema, json: Json, root: JsonSchema): boolean {
  if (schema.$ref !== undefined) {
    const definition = root.$defs?.[schema.$ref.replace("#/$defs/", "")];
    return definition !== undefined && takes(definition, json, root);
  }
  if (schema.anyOf !== undefined) return schema.anyOf.some((part) => takes(part, json, root));
  if (schema.const !== undefined) return schema.const === json;
  if (schema.enum !== undefined) return schema.enum.includes(json);
  const types = [schema.type].flat();
  const fits = types.includes(typeOf(json)) || (types.includes("integer") && Number.isInteger(json));
  return fits && withinLimits(schema, json, root);
}

function typeOf(json: Json): string {
  if (json === null) return "null";
  if (Array.isArray(json)) return "array";
  return typeof json;
}

function withinLimits(schema: JsonSchema & { pattern?: string }, json: Json, root: JsonSchema): boolean {
  if (typeof json === "number") {
    return json >= (schema.minimum ?? -Infinity) && json <= (schema.maximum ?? Infinity);
  }
  if (typeof json === "string") {
    const fits = [...json].length <= (schema.maxLength ?? Infinity);
    return fits && (schema.pattern === undefined || new RegExp(schema.pattern).test(json));
  }
  if (Array.isArray(json)) {
    const fits = json.length >= (schema.minItems ?? 0) && json.length <= (schema.maxItems ?? Infinity);
    return fits && json.every((item) => takes(schema.items ?? {}, item, root));
  }
  if (typeof json === "object" && json !== null) {
    return Object.entries(json).every(([name, value]) => {
      const property = schema.properties?.[name];
      return property !== undefined && takes(property, value, root);
    });
  }
  return true;
}
