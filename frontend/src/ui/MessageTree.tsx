import { useState } from "react";
import {
  descriptionOf,
  fieldNode,
  itemNode,
  type JsonSchema,
  rootNode,
  type SchemaNode,
  typeOf,
} from "../api/jsonSchema";
import { Breakable } from "./Fact";
import classes from "./MessageTree.module.css";
import {
  hasParts,
  isAbsent,
  isMessage,
  isShort,
  MAX_ITEMS,
  momentOf,
  valueWords,
  withDigits,
} from "./messageWords";
import { NO_DIGITS } from "./numbers";
import { Time } from "./Time";

interface MessageTreeProps {
  /** A message as the gateway writes it. */
  value: unknown;
  /** Of `/interfaces/{type}`, where it is known: gives units, constants and descriptions. */
  schema?: JsonSchema | undefined;
  /** What it is, to a screen reader. */
  label: string;
  /** The number of levels that are unfolded at first; short messages are in any level. */
  open?: number;
}

/** A message to read: a field a line, messages within it to fold. Keeps what is unfolded while the message changes. */
export function MessageTree({ value, schema, label, open = 1 }: MessageTreeProps) {
  const node = rootNode(schema);
  return (
    <div className={classes.tree} data-testid="message-tree">
      {hasParts(value) ? (
        <Parts value={value} node={node} open={open} label={label} />
      ) : (
        <Value value={value} node={node} />
      )}
    </div>
  );
}

interface PartsProps {
  value: Record<string, unknown> | unknown[];
  node: SchemaNode | undefined;
  open: number;
  label?: string;
}

function Parts({ value, node, open, label }: PartsProps) {
  if (Array.isArray(value)) {
    const item = itemNode(node);
    const left = value.length - MAX_ITEMS;
    return (
      <ul className={classes.parts} aria-label={label}>
        {value.slice(0, MAX_ITEMS).map((each, index) => (
          // biome-ignore lint/suspicious/noArrayIndexKey: an item of a message is known by its place alone
          <Part key={index} name={`[${index}]`} value={each} node={item} open={open} />
        ))}
        {left > 0 && <li className={classes.absent}>… and {left} more</li>}
      </ul>
    );
  }
  return <Fields value={value} node={node} open={open} {...(label !== undefined && { label })} />;
}

/** So many fields that say nothing are folded into a line. */
const FOLDED_FROM = 3;

/** What was measured, and folded below it what was not. A field that had a value stays in its place when it has none. */
function Fields({ value, node, open, label }: PartsProps & { value: Record<string, unknown> }) {
  const [told, setTold] = useState<ReadonlySet<string>>(new Set());
  const fields = Object.entries(value);
  const fresh = fields.flatMap(([name, each]) => (isAbsent(each) || told.has(name) ? [] : [name]));
  if (fresh.length > 0) setTold(new Set([...told, ...fresh]));
  const silent = fields.filter(([name]) => !told.has(name) && !fresh.includes(name));
  const folded = silent.length >= FOLDED_FROM && silent.length < fields.length ? silent : [];
  const part = ([name, each]: [string, unknown]) => (
    <Part key={name} name={name} value={each} node={fieldNode(node, name)} open={open} />
  );
  return (
    <ul className={classes.parts} aria-label={label}>
      {fields.filter((field) => !folded.includes(field)).map(part)}
      {folded.length > 0 && (
        <li>
          <details className={classes.message}>
            <summary className={classes.absent}>{folded.length} not measured or empty</summary>
            <ul className={classes.parts}>{folded.map(part)}</ul>
          </details>
        </li>
      )}
      {fields.length === 0 && <li className={classes.absent}>has no fields</li>}
    </ul>
  );
}

interface PartProps {
  name: string;
  value: unknown;
  node: SchemaNode | undefined;
  open: number;
}

function Part({ name, value, node, open }: PartProps) {
  const moment = isMessage(value) ? momentOf(value, node) : null;
  if (moment === null && hasParts(value)) return <Fold name={name} value={value} node={node} open={open} />;
  return (
    <li className={classes.field}>
      <Name name={name} node={node} />{" "}
      {moment === null ? (
        <Value value={value} node={node} />
      ) : (
        <span className={classes.value}>
          {moment.kind === "words" ? moment.words : <Time value={moment.ms} />}
        </span>
      )}
    </li>
  );
}

function Fold({ name, value, node, open }: PartProps & PartsProps) {
  // Of the message that came first: what somebody folds stays so, whatever comes.
  const [unfolded] = useState(() => open > 0 || isShort(value));
  return (
    <li>
      <details open={unfolded} className={classes.message}>
        <summary>
          <Name name={name} node={node} />
          <span className={classes.type}>{kindWords(value, node)}</span>
        </summary>
        <Parts value={value} node={node} open={open - 1} />
      </details>
    </li>
  );
}

/** A value without parts, with as many decimals as it has had so far: a number that changes does not jitter. */
function Value({ value, node }: Pick<PartProps, "value" | "node">) {
  const [known, setKnown] = useState(() => withDigits(NO_DIGITS, value));
  const digits = withDigits(known, value);
  if (digits !== known) setKnown(digits);
  return (
    <span className={classes.value} data-absent={isAbsent(value) || undefined}>
      {valueWords(value, node, digits)}
    </span>
  );
}

function Name({ name, node }: { name: string; node: SchemaNode | undefined }) {
  return (
    <span className={classes.name} title={descriptionOf(node) ?? undefined}>
      <Breakable text={name} />
    </span>
  );
}

function kindWords(value: Record<string, unknown> | unknown[], node: SchemaNode | undefined): string {
  if (Array.isArray(value)) return `${value.length} × ${typeOf(itemNode(node)) ?? "message"}`;
  return typeOf(node) ?? "";
}
