import { isArray, isObject, type Json } from "../../api/jsonSchema";
import { numberText } from "./numbers";
import type {
  BytesShape,
  Field,
  FloatShape,
  IntegerShape,
  ListShape,
  MessageShape,
  NumbersShape,
  Shape,
} from "./shapes";
import { dotted, type Path, type Value, type Values } from "./shapes";
import type { FieldError } from "./write";

interface Read {
  values: Values;
  /** What a form cannot show; what is only too large or too long it can. */
  errors: readonly FieldError[];
}

/** The values of a form that make this message; what the message leaves out has its default. */
export function readMessage(shape: MessageShape, json: Json): Read {
  const reader = new Reader();
  return { values: reader.message(shape, json, []), errors: reader.errors };
}

/** What a message's form holds before anybody typed. */
export function initialValues(shape: MessageShape): Values {
  return Object.fromEntries(shape.fields.map((field) => [field.name, initialOf(field)]));
}

/** What a field holds before anybody typed: its default. */
export function initialOf({ shape, initial }: Field): Value {
  return initial === undefined ? emptyOf(shape) : new Reader().any(shape, initial, []);
}

/** What a new item of a list holds. */
export function emptyOf(shape: Shape): Value {
  switch (shape.kind) {
    case "boolean":
      return false;
    case "integer":
      return String(shape.low > 0n ? shape.low : 0n);
    case "float":
      return shape.unset ? "" : "0";
    case "text":
    case "numbers":
      return "";
    case "bytes":
      return { encoding: "numbers", text: "" };
    case "list":
      return Array.from({ length: shape.low }, () => emptyOf(shape.item));
    case "message":
      return initialValues(shape);
  }
}

class Reader {
  readonly errors: FieldError[] = [];

  message(shape: MessageShape, json: Json, path: Path): Values {
    if (!isObject(json)) {
      this.#wrong(path, "an object", json);
      return initialValues(shape);
    }
    const names = new Set(shape.fields.map((field) => field.name));
    for (const name of Object.keys(json)) {
      if (!names.has(name)) {
        this.errors.push({
          path: dotted([...path, name]),
          detail: `there is no such field: expected one of ${[...names].join(", ")}`,
        });
      }
    }
    return Object.fromEntries(
      shape.fields.map((field) => {
        const given = json[field.name];
        const value =
          given === undefined ? initialOf(field) : this.any(field.shape, given, [...path, field.name]);
        return [field.name, value];
      }),
    );
  }

  any(shape: Shape, json: Json, path: Path): Value {
    switch (shape.kind) {
      case "boolean":
        return typeof json === "boolean" ? json : this.#instead(shape, path, "true or false", json);
      case "integer":
        return this.#integer(shape, json, path) ?? emptyOf(shape);
      case "float":
        return this.#float(shape, json, path) ?? emptyOf(shape);
      case "text":
        return typeof json === "string" ? json : this.#instead(shape, path, "a string", json);
      case "numbers":
        return this.#numbers(shape, json, path);
      case "bytes":
        return this.#bytes(shape, json, path);
      case "list":
        return this.#list(shape, json, path);
      case "message":
        return this.message(shape, json, path);
    }
  }

  #integer({ wide, choices }: IntegerShape, json: Json, path: Path): string | undefined {
    if (typeof json === "number") {
      if (!wide || Number.isSafeInteger(json) || !Number.isInteger(json)) return numberText(json);
      this.errors.push({
        path: dotted(path),
        detail: "expected a string: JSON rounds a number as large as this",
      });
      return undefined;
    }
    if (typeof json === "string") {
      // A constant's full name begins with that of its field.
      const name = json.toUpperCase();
      const full = `${String(path.findLast((step) => typeof step === "string"))}_`.toUpperCase();
      const choice = choices.find((each) => each.name === name || `${full}${each.name}` === name);
      if (choice !== undefined) return String(choice.value);
      if (wide && /^-?\d+$/.test(json)) return json;
    }
    this.#wrong(path, choices.length > 0 ? "a number or the name of a constant" : "a whole number", json);
    return undefined;
  }

  #float({ unset }: FloatShape, json: Json, path: Path): string | undefined {
    if (json === null && unset) return "";
    if (json === null || typeof json === "number") return numberText(json);
    this.#wrong(path, "a number or null", json);
    return undefined;
  }

  #numbers({ item }: NumbersShape, json: Json, path: Path): string {
    if (!isArray(json)) {
      this.#wrong(path, "an array", json);
      return "";
    }
    const texts = json.map((each, index) =>
      item.kind === "integer"
        ? this.#integer(item, each, [...path, index])
        : this.#float({ ...item, unset: false }, each, [...path, index]),
    );
    return texts.join(", ");
  }

  #bytes(shape: BytesShape, json: Json, path: Path): Value {
    if (typeof json === "string") return { encoding: "base64", text: json };
    const item = { kind: "integer", low: 0n, high: 255n, wide: false, choices: [] } as const;
    return { encoding: "numbers", text: this.#numbers({ ...shape, kind: "numbers", item }, json, path) };
  }

  #list(shape: ListShape, json: Json, path: Path): Value {
    if (!isArray(json)) return this.#instead(shape, path, "an array", json);
    return json.map((item, index) => this.any(shape.item, item, [...path, index]));
  }

  #instead(shape: Shape, path: Path, expected: string, json: Json): Value {
    this.#wrong(path, expected, json);
    return emptyOf(shape);
  }

  #wrong(path: Path, expected: string, json: Json): void {
    this.errors.push({ path: dotted(path), detail: `expected ${expected}, got ${kindOf(json)}` });
  }
}

function kindOf(json: Json): string {
  if (json === null) return "null";
  if (isArray(json)) return "an array";
  if (isObject(json)) return "an object";
  return typeof json === "string" ? "a string" : `${json}`;
}
