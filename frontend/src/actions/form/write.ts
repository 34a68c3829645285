import { type Json, type JsonObject, same } from "../../api/jsonSchema";
import { shortest } from "../../ui/numbers";
import { base64Length, type Parsed, parseNumber, splitNumbers } from "./numbers";
import { initialOf } from "./read";
import type {
  BytesShape,
  Field,
  Length,
  ListShape,
  MessageShape,
  NumbersShape,
  Shape,
  TextShape,
} from "./shapes";
import { type Bytes, dotted, type Path, type Value, type Values } from "./shapes";

/** What is wrong with a field. */
export interface FieldError {
  /** As in `pose.covariance.3`. */
  path: string;
  detail: string;
}

interface Written {
  /** Without what is as it would be anyway, and without what is wrong. */
  message: JsonObject;
  errors: readonly FieldError[];
}

/** The message that a form's values make. */
export function writeMessage(shape: MessageShape, values: Values): Written {
  const writer = new Writer();
  return { message: writer.message(shape, values, []), errors: writer.errors };
}

/** What a field is when it is left out; undefined where that is not known. */
const defaults = new WeakMap<Field, { json: Json | undefined }>();

function defaultOf(field: Field): Json | undefined {
  let known = defaults.get(field);
  if (known === undefined) {
    known = { json: new Writer().any(field.shape, initialOf(field), [], field) };
    defaults.set(field, known);
  }
  return known.json;
}

class Writer {
  readonly errors: FieldError[] = [];

  message(shape: MessageShape, values: Values, path: Path): JsonObject {
    const message: Record<string, Json> = {};
    for (const field of shape.fields) {
      const json = this.any(
        field.shape,
        values[field.name] ?? initialOf(field),
        [...path, field.name],
        field,
      );
      if (json !== undefined && !same(json, defaultOf(field))) message[field.name] = json;
    }
    return message;
  }

  /** The JSON of a value; undefined where it is left out or wrong. */
  any(shape: Shape, value: Value, path: Path, field?: Field): Json | undefined {
    switch (shape.kind) {
      case "boolean":
        return value === true;
      case "integer":
      case "float":
        return this.#take(parseNumber(value as string, shape), path);
      case "text":
        return this.#text(shape, value as string, path);
      case "numbers":
        return this.#numbers(shape, value as string, path, field);
      case "bytes":
        return this.#bytes(shape, value as Bytes, path, field);
      case "list":
        return this.#list(shape, value as readonly Value[], path);
      case "message":
        return this.message(shape, value as Values, path);
    }
  }

  #text({ high }: TextShape, text: string, path: Path): Json | undefined {
    if (text.includes("\0")) return this.#wrong(path, "expected a text without NUL characters");
    // ROS counts characters, JavaScript halves of some of them.
    const length = text.length <= high ? text.length : [...text].length;
    return length <= high ? text : this.#wrong(path, `expected at most ${high} characters, got ${length}`);
  }

  #numbers(shape: NumbersShape, text: string, path: Path, field?: Field): Json | undefined {
    const parts = splitNumbers(text);
    if (parts.length === 0 && field?.initial === undefined) return undefined;
    const before = this.errors.length;
    this.#checkLength(shape, parts.length, path, "number");
    const numbers: Json[] = [];
    for (const [index, part] of parts.entries()) {
      const parsed = parseNumber(part, shape.item);
      if ("value" in parsed) numbers.push(parsed.value);
      else {
        this.#wrong([...path, index], `number ${index + 1}, ${shown(part)}: expected ${parsed.expected}`);
        // One tells what is wrong with all of them.
        break;
      }
    }
    return this.errors.length === before ? numbers : undefined;
  }

  #bytes(shape: BytesShape, { encoding, text }: Bytes, path: Path, field?: Field): Json | undefined {
    const plain = text.replace(/\s/g, "");
    if (encoding === "numbers" || plain === "") {
      return this.#numbers({ ...shape, kind: "numbers", item: BYTE }, text, path, field);
    }
    const length = base64Length(plain);
    if (length === null) return this.#wrong(path, "expected base64 with its padding (=)");
    return this.#checkLength(shape, length, path, "byte") ? plain : undefined;
  }

  #list(shape: ListShape, items: readonly Value[], path: Path): Json | undefined {
    const before = this.errors.length;
    this.#checkLength(shape, items.length, path, "item");
    const json = items.map((item, index) => this.any(shape.item, item, [...path, index]) ?? null);
    return this.errors.length === before ? json : undefined;
  }

  #checkLength({ low, high }: Length, length: number, path: Path, item: string): boolean {
    if (length >= low && length <= high) return true;
    this.#wrong(path, `expected ${lengthWords({ low, high }, item)}, got ${length}`);
    return false;
  }

  #take(parsed: Parsed<Json>, path: Path): Json | undefined {
    return "value" in parsed ? parsed.value : this.#wrong(path, `expected ${parsed.expected}`);
  }

  #wrong(path: Path, detail: string): undefined {
    this.errors.push({ path: dotted(path), detail });
    return undefined;
  }
}

const BYTE = { kind: "integer", low: 0n, high: 255n, wide: false, choices: [] } as const;

/** `3 numbers`, `at most 8 items`, `at least 1 byte`; empty where any number of them is fine. */
export function lengthWords({ low, high }: Length, item: string): string {
  const many = (count: number) => `${shortest(count, 0)} ${item}${count === 1 ? "" : "s"}`;
  if (low === high) return many(low);
  if (low === 0) return Number.isFinite(high) ? `at most ${many(high)}` : "";
  return Number.isFinite(high) ? `${low} to ${many(high)}` : `at least ${many(low)}`;
}

function shown(text: string): string {
  return text.length > 20 ? `“${text.slice(0, 20)}…”` : `“${text}”`;
}
