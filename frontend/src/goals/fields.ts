import { fieldNode, itemNode, type JsonSchema, rootNode, type SchemaNode } from "../api/jsonSchema";
import { isMessage, type Message } from "../ui/messageWords";
import { type Digits, NO_DIGITS, withNumber } from "../ui/numbers";

/** A number within messages of one type: where it is, and how an array becomes one number. */
export interface NumericField {
  /** As in the columns of the CSV: `current_battery_state.voltage`, `cell_voltage.0`; `sequence (last)`. */
  name: string;
  path: readonly (string | number)[];
  /** Which number of an array is shown: its last item, or its length. */
  of?: "last" | "length";
}

export interface FoundField extends NumericField {
  min: number;
  max: number;
  /** How its numbers are written. */
  digits: Digits;
}

/** Items of an array that are fields of their own. */
const MAX_ITEMS = 8;

/** Enough for any message that a person looks at. */
const MAX_FIELDS = 200;

/** What of messages can be plotted: the numbers that were measured at least once. */
export class FieldsFound {
  readonly #found = new Map<string, FoundField>();

  /** Changes where there is one more, and where one has other digits. */
  version = 0;

  /** In the order of the message's fields. */
  get all(): readonly FoundField[] {
    return [...this.#found.values()];
  }

  /** Looks at one more message. */
  look(message: Message): void {
    visit(message, [], (field, value) => {
      const known = this.#found.get(field.name);
      if (known !== undefined) {
        if (value < known.min) known.min = value;
        if (value > known.max) known.max = value;
        const digits = withNumber(known.digits, value);
        if (digits !== known.digits) this.version += 1;
        known.digits = digits;
      } else if (this.#found.size < MAX_FIELDS) {
        this.version += 1;
        this.#found.set(field.name, {
          ...field,
          min: value,
          max: value,
          digits: withNumber(NO_DIGITS, value),
        });
      }
    });
  }
}

/** The field that is plotted by default: the first that changes, else the first. */
export function mostTelling(fields: readonly FoundField[]): FoundField | null {
  return fields.find(({ min, max }) => max > min) ?? fields[0] ?? null;
}

/** The number that a message has there; null where it was not measured or has no such place. */
export function numberAt(message: Message, field: NumericField): number | null {
  let value: unknown = message;
  for (const step of field.path) {
    if (typeof value !== "object" || value === null) return null;
    value = (value as Record<string | number, unknown>)[step];
  }
  if (field.of !== undefined) {
    if (!Array.isArray(value)) return null;
    value = field.of === "length" ? value.length : value.at(-1);
  }
  return toNumber(value);
}

type Visitor = (field: NumericField, value: number) => void;

function visit(value: unknown, path: readonly (string | number)[], found: Visitor): void {
  const number = toNumber(value);
  if (number !== null) found({ name: path.join("."), path }, number);
  else if (Array.isArray(value)) visitArray(value, path, found);
  else if (isMessage(value)) {
    // The time of a measurement is on the other axis.
    for (const [name, each] of Object.entries(value))
      if (name !== "stamp") visit(each, [...path, name], found);
  }
}

function visitArray(values: readonly unknown[], path: readonly (string | number)[], found: Visitor): void {
  const name = path.join(".");
  const last = toNumber(values.at(-1));
  if (last !== null) {
    found({ name: `${name} (last)`, path, of: "last" }, last);
    found({ name: `${name} (length)`, path, of: "length" }, values.length);
  }
  values.slice(0, MAX_ITEMS).forEach((value, index) => {
    visit(value, [...path, index], found);
  });
}

/** A duration is its seconds. */
function toNumber(value: unknown): number | null {
  if (typeof value === "number") return value;
  if (!isMessage(value)) return null;
  const { sec, nanosec } = value;
  return typeof sec === "number" && typeof nanosec === "number" ? sec + nanosec / 1e9 : null;
}

/** What the schema of the messages says of a field. */
export function nodeOf(schema: JsonSchema | undefined, field: NumericField): SchemaNode | undefined {
  let node = rootNode(schema);
  for (const step of field.path) node = typeof step === "number" ? itemNode(node) : fieldNode(node, step);
  return field.of === "last" ? itemNode(node) : field.of === "length" ? undefined : node;
}

/** The last part of a field's name, where no other field's is the same. */
export function shortNames(fields: readonly NumericField[]): string[] {
  const lasts = fields.map(({ path, of }) => {
    const named = path.findLastIndex((step) => typeof step === "string");
    return `${path.slice(named).join(".")}${of === undefined ? "" : ` (${of})`}`;
  });
  return fields.map(({ name }, index) => {
    const last = lasts[index] ?? name;
    return lasts.filter((other) => other === last).length > 1 ? name : last;
  });
}
