import { constantName, itemNode, type SchemaNode, typeOf, unitOf } from "./jsonSchema";

/** What a page says where a number is NaN. */
export const NOT_MEASURED = "not measured";

/** Items of an array that are told; JSON has them all. */
export const MAX_ITEMS = 60;

const MAX_TEXT = 2000;

export type Message = Record<string, unknown>;

export function isMessage(value: unknown): value is Message {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

/** A message, or an array with messages: what has parts of its own. */
export function hasParts(value: unknown): value is Message | unknown[] {
  return isMessage(value) || (Array.isArray(value) && value.some((item) => typeof item === "object" && item));
}

/** A value without parts in words, with its unit or the name of its constant: `2.16 V`, `CHARGING (1)`, `not measured`. */
export function valueWords(value: unknown, node?: SchemaNode): string {
  if (Array.isArray(value)) return arrayWords(value, node);
  const constant = constantName(node, value);
  if (constant !== null) return `${constant} (${value})`;
  const unit = unitOf(node);
  return unit === null || value === null ? scalarWords(value) : `${scalarWords(value)} ${unit}`;
}

function arrayWords(values: readonly unknown[], node: SchemaNode | undefined): string {
  if (values.length === 0) return "empty";
  const item = itemNode(node);
  const unit = unitOf(item);
  const texts = values
    .slice(0, MAX_ITEMS)
    .map((value) => (constantName(item, value) === null ? scalarWords(value) : valueWords(value, item)));
  const left = values.length - MAX_ITEMS;
  return `${texts.join(", ")}${unit === null ? "" : ` ${unit}`}${left > 0 ? ` … and ${left} more` : ""}`;
}

function scalarWords(value: unknown): string {
  if (value === null || value === undefined) return NOT_MEASURED;
  if (value === "") return "empty";
  const text = String(value);
  return text.length > MAX_TEXT ? `${text.slice(0, MAX_TEXT)} … and ${text.length - MAX_TEXT} more` : text;
}

/** Whether words stand in the place of a value that is not there. */
export function isAbsent(value: unknown): boolean {
  return (
    value === null || value === undefined || value === "" || (Array.isArray(value) && value.length === 0)
  );
}

/** 2001: what is earlier is a clock that began with a simulation. */
const WALL_S = 1_000_000_000;

export type Moment = { kind: "time"; ms: number } | { kind: "words"; words: string };

/** A builtin_interfaces/Time or Duration as one value; null where the message is neither. */
export function momentOf(value: Message, node?: SchemaNode): Moment | null {
  const { sec, nanosec, ...rest } = value;
  if (typeof sec !== "number" || typeof nanosec !== "number" || Object.keys(rest).length > 0) return null;
  const type = typeOf(node);
  if (type === null) return null;
  const seconds = sec + nanosec / 1e9;
  if (type !== "builtin_interfaces/Time") return { kind: "words", words: `${seconds} s` };
  if (seconds === 0) return { kind: "words", words: "not set" };
  return seconds < WALL_S ? { kind: "words", words: `${seconds} s` } : { kind: "time", ms: seconds * 1000 };
}
