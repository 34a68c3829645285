import { isObject, type Json, type JsonObject } from "../../api/jsonSchema";
import { initialValues, readMessage } from "./read";
import type { MessageShape } from "./shapes";
import { dotted, type Path, type Value, type Values, withValue } from "./shapes";
import { type FieldError, writeMessage } from "./write";

/** A goal that is being written, as a form or as JSON. */
export interface Draft {
  mode: "form" | "json";
  values: Values;
  /** The JSON, where that is what is written. */
  text: string;
  /** The JSON that the values made when it was last asked for. */
  written: string;
  /** What the gateway said was wrong with what was sent. */
  refused: readonly FieldError[];
}

/** What a draft amounts to. */
interface Outgoing {
  /** The body of the request, as it is sent; null where there is none. */
  body: string | null;
  /** The body as data if the form makes it; else null. */
  message: JsonObject | null;
  /** Whether it may be sent: what the gateway refused before is for the gateway to judge again. */
  ready: boolean;
  /** Errors that this page finds, and those that the gateway answered. */
  errors: readonly FieldError[];
}

/** @param message What to begin with; defaults for what it leaves out. */
export function newDraft(shape: MessageShape, message: Json = {}): Draft {
  const { values } = readMessage(shape, message);
  return { mode: "form", values, text: "", written: "", refused: [] };
}

export function withField(draft: Draft, path: Path, value: Value): Draft {
  const where = dotted(path);
  const refused = draft.refused.filter(({ path: at }) => !isAt(at, where) && !isAt(where, at));
  return { ...draft, values: withValue(draft.values, path, value), refused };
}

export function withText(draft: Draft, text: string): Draft {
  return { ...draft, text, refused: [] };
}

/** Resets a draft to the defaults of the definition. */
export function withDefaults(draft: Draft, shape: MessageShape): Draft {
  return { ...draft, values: initialValues(shape), text: "{}", refused: [] };
}

export function asJson(draft: Draft, shape: MessageShape): Draft {
  const text = JSON.stringify(writeMessage(shape, draft.values).message, null, 2);
  return { ...draft, mode: "json", text, written: text };
}

/** The draft as a form, or what the form cannot show of it. */
export function asForm(draft: Draft, shape: MessageShape): Draft | readonly FieldError[] {
  // What is only half typed in the form is not in the JSON: it is kept unless somebody changed that.
  if (draft.text === draft.written) return { ...draft, mode: "form" };
  const parsed = parse(draft.text);
  if ("detail" in parsed) return [parsed];
  const { values, errors } = readMessage(shape, parsed.json);
  return errors.length > 0 ? errors : { ...draft, mode: "form", values };
}

export function outgoing(draft: Draft, shape: MessageShape): Outgoing {
  const { body, message, errors } = draft.mode === "form" ? fromForm(draft, shape) : fromJson(draft, shape);
  const ready = body !== null && errors.length === 0;
  return { body, message, ready, errors: [...errors, ...draft.refused] };
}

function fromForm(draft: Draft, shape: MessageShape): Omit<Outgoing, "ready"> {
  const { message, errors } = writeMessage(shape, draft.values);
  return { body: spaced(message), message, errors };
}

function fromJson(draft: Draft, shape: MessageShape): Omit<Outgoing, "ready"> {
  const parsed = parse(draft.text);
  if ("detail" in parsed) return { body: null, message: null, errors: [parsed] };
  const read = readMessage(shape, parsed.json);
  const errors = read.errors.length > 0 ? read.errors : writeMessage(shape, read.values).errors;
  return { body: isObject(parsed.json) ? draft.text.trim() : null, message: null, errors };
}

/** What is wrong with a field itself. */
export function errorsAt(errors: readonly FieldError[], where: string): readonly FieldError[] {
  return errors.filter((error) => error.path === where);
}

/** What is wrong with a field or within it. */
export function errorsIn(errors: readonly FieldError[], where: string): readonly FieldError[] {
  return where === "" ? errors : errors.filter((error) => isAt(error.path, where));
}

function isAt(path: string, where: string): boolean {
  return path === where || path.startsWith(`${where}.`);
}

function parse(text: string): { json: Json } | FieldError {
  try {
    return { json: JSON.parse(text) as Json };
  } catch (error) {
    return { path: "", detail: `this is not JSON: ${error instanceof Error ? error.message : error}` };
  }
}

/** Leaves out the fields of a message that have their default. */
export function withoutDefaults(shape: MessageShape, message: Json): JsonObject {
  return writeMessage(shape, readMessage(shape, message).values).message;
}

/** JSON on one line, as people write it: `{"order": 10}`. */
export function spaced(json: Json): string {
  // A line break within a text is written \n, so that these are all between values.
  return JSON.stringify(json, null, 1)
    .replace(/([[{])\n\s*/g, "$1")
    .replace(/\n\s*([\]}])/g, "$1")
    .replace(/\n\s*/g, " ");
}
