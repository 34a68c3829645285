import type { Json } from "../../api/jsonSchema";
import type { Bytes, FloatShape, IntegerShape } from "./shapes";

/** What a text stands for, or what was expected instead. */
export type Parsed<Value> = { value: Value } | { expected: string };

const WHOLE = /^[+-]?\d+$/;
const DECIMAL = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;
const NOT_MEASURED = /^(nan|null|-)$/i;

/** A number out of a text as people write it: with a minus of either kind. */
export function parseNumber(text: string, shape: IntegerShape | FloatShape): Parsed<Json> {
  const plain = text.trim().replace(/^[−–]/, "-");
  return shape.kind === "integer" ? parseInteger(plain, shape) : parseFloating(plain, shape);
}

function parseInteger(text: string, { low, high }: IntegerShape): Parsed<Json> {
  const expected = `a whole number from ${signed(low)} to ${high}`;
  // A longer text is out of every range, and slow to read.
  if (!WHOLE.test(text) || text.length > 40) return { expected };
  const number = BigInt(text.replace("+", ""));
  if (number < low || number > high) return { expected };
  const safe = Number.isSafeInteger(Number(number));
  return { value: safe ? Number(number) : String(number) };
}

function parseFloating(text: string, { limit, unset }: FloatShape): Parsed<Json> {
  if (NOT_MEASURED.test(text) || (text === "" && unset)) return { value: null };
  if (!DECIMAL.test(text)) {
    return {
      expected: unset ? "a number, or nothing for not measured" : "a number, or NaN for not measured",
    };
  }
  const number = Number(text);
  if (Math.abs(number) > limit) {
    return { expected: limit < 1e39 ? "a number from −3.4e38 to 3.4e38" : "a number that a float64 holds" };
  }
  return { value: number };
}

/** Numbers between commas, spaces or line breaks, in brackets or not. */
export function splitNumbers(text: string): string[] {
  const inside = text.trim().replace(/^\[/, "").replace(/\]$/, "");
  return inside.split(/[\s,;]+/).filter((part) => part !== "");
}

/** A number as it stands in a field. */
export function numberText(json: Json): string {
  if (json === null) return "NaN";
  return Object.is(json, -0) ? "-0" : String(json);
}

/** How many bytes a base64 text stands for; null where it is none. */
export function base64Length(text: string): number | null {
  if (text.length % 4 !== 0 || !/^[A-Za-z0-9+/]*={0,2}$/.test(text)) return null;
  const padding = text.endsWith("==") ? 2 : text.endsWith("=") ? 1 : 0;
  return (text.length / 4) * 3 - padding;
}

function signed(number: bigint): string {
  return number < 0n ? `−${-number}` : String(number);
}

/** The number of bytes; null where the text is not valid. */
export function countBytes({ encoding, text }: Bytes): number | null {
  return encoding === "numbers" ? splitNumbers(text).length : base64Length(withoutSpaces(text));
}

/** Writes bytes in another encoding; text that is not valid stays as it is. */
export function convertBytes(bytes: Bytes, encoding: Bytes["encoding"]): Bytes {
  if (bytes.encoding === encoding) return bytes;
  return { encoding, text: (encoding === "base64" ? toBase64 : toNumbers)(bytes.text) };
}

function toBase64(text: string): string {
  const numbers = splitNumbers(text).map(Number);
  if (!numbers.every((number) => Number.isInteger(number) && number >= 0 && number <= 255)) return text;
  return btoa(numbers.map((number) => String.fromCharCode(number)).join(""));
}

function toNumbers(text: string): string {
  const plain = withoutSpaces(text);
  if (base64Length(plain) === null) return text;
  return [...atob(plain)].map((character) => character.charCodeAt(0)).join(", ");
}

function withoutSpaces(text: string): string {
  return text.replace(/\s/g, "");
}
