import { constantName, itemNode, type SchemaNode, typeOf, unitOf } from "../api/jsonSchema";
import { alike, type Digits, NO_DIGITS, withNumber } from "./numbers";

/** What a page says where a number is NaN. */
export const NOT_MEASURED = "not measured";

/** The number of items of an array that are listed; JSON has them all. */
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

/** A message with more lines than this is folded. */
const MAX_LINES = 8;

/** Whether something with parts is short enough to show unasked. A header says nothing that matters. */
export function isShort(value: Message | unknown[]): boolean {
  return !("frame_id" in value && "stamp" in value) && linesOf(value) <= MAX_LINES;
}

function linesOf(value: unknown): number {
  if (!hasParts(value)) return 1;
  return Object.values(value).reduce<number>((sum, part) => sum + linesOf(part), 0);
}

/** What the numbers of a value without parts have in common, also with those that it had before. */
export function withDigits(digits: Digits, value: unknown): Digits {
  if (typeof value === "number") return withNumber(digits, value);
  return Array.isArray(value) ? value.reduce(withDigits, digits) : digits;
}

/**
 * A value without parts in words, with its unit or the name of its constant: `2.16 V`, `CHARGING (1)`, `not measured`.
 *
 * @param digits How its numbers are written.
 */
export function valueWords(
  value: unknown,
  node?: SchemaNode,
  digits: Digits = withDigits(NO_DIGITS, value),
): string {
  if (Array.isArray(value)) return arrayWords(value, node, digits);
  const constant = constantName(node, value);
  if (constant !== null) return `${constant} (${value})`;
  const unit = unitOf(node);
  const words = scalarWords(value, digits);
  return unit === null || value === null ? words : `${words} ${unit}`;
}

/** At least this many equal items in a row are written as one. */
const MIN_RUN = 5;

function arrayWords(values: readonly unknown[], node: SchemaNode | undefined, digits: Digits): string {
  if (values.length === 0) return "empty";
  const item = itemNode(node);
  const unit = unitOf(item);
  const texts: string[] = [];
  let next = 0;
  while (next < values.length && texts.length < MAX_ITEMS) {
    const value = values[next];
    const words =
      constantName(item, value) === null ? scalarWords(value, digits) : valueWords(value, item, digits);
    const run = runAt(values, next);
    texts.push(run >= MIN_RUN ? `${run} × ${words}` : words);
    next += run >= MIN_RUN ? run : 1;
  }
  const left = values.length - next;
  return `${texts.join(", ")}${unit === null ? "" : ` ${unit}`}${left > 0 ? ` … and ${left} more` : ""}`;
}

/** How many equal values begin there. */
function runAt(values: readonly unknown[], start: number): number {
  let end = start + 1;
  while (end < values.length && values[end] === values[start]) end += 1;
  return end - start;
}

function scalarWords(value: unknown, digits: Digits): string {
  if (value === null || value === undefined) return NOT_MEASURED;
  if (value === "") return "empty";
  if (typeof value === "number") return alike(value, digits);
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

/** Milliseconds. */
const SECONDS_DECIMALS = 3;

type Moment = { kind: "time"; ms: number } | { kind: "words"; words: string };

/** A builtin_interfaces/Time or Duration as one value; null where the message is neither. */
export function momentOf(value: Message, node?: SchemaNode): Moment | null {
  const { sec, nanosec, ...rest } = value;
  if (typeof sec !== "number" || typeof nanosec !== "number" || Object.keys(rest).length > 0) return null;
  const type = typeOf(node);
  if (type === null) return null;
  const seconds = sec + nanosec / 1e9;
  const words = `${alike(seconds, { decimals: SECONDS_DECIMALS, magnitude: 0 })} s`;
  if (type !== "builtin_interfaces/Time") return { kind: "words", words };
  if (seconds === 0) return { kind: "words", words: "not set" };
  return seconds < WALL_S ? { kind: "words", words } : { kind: "time", ms: seconds * 1000 };
}
