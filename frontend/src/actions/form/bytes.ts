import { base64Length, splitNumbers } from "./numbers";
import type { Bytes } from "./values";

/** How many bytes there are; null where that cannot be told. */
export function countBytes({ encoding, text }: Bytes): number | null {
  return encoding === "numbers" ? splitNumbers(text).length : base64Length(withoutSpaces(text));
}

/** The same bytes written the other way; the text as it is where it is not valid. */
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
