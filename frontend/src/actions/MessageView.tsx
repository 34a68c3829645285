import { Text } from "@mantine/core";
import type { JsonSchema } from "../api/jsonSchema";
import { MessageTree } from "../ui/MessageTree";
import classes from "./actions.module.css";

interface MessageViewProps {
  title: string;
  message: Record<string, unknown>;
  schema: JsonSchema;
  /** Whether more of it is to come. */
  growing: boolean;
}

/** A feedback or a result: whole numbers in a row as a sequence, the rest as a tree. */
export function MessageView({ title, message, schema, growing }: MessageViewProps) {
  const entries = Object.entries(message);
  const rest = Object.fromEntries(entries.filter(([, value]) => !isSequence(value)));
  return (
    <>
      {entries.map(
        ([name, value]) =>
          isSequence(value) && <Sequence key={name} name={name} numbers={value} growing={growing} />,
      )}
      {(Object.keys(rest).length > 0 || entries.length === 0) && (
        <div>
          <Text size="sm" mb={4}>
            {title}
          </Text>
          <MessageTree value={rest} schema={schema} label={title} />
        </div>
      )}
    </>
  );
}

function isSequence(value: unknown): value is number[] {
  return Array.isArray(value) && value.length > 0 && value.every(Number.isInteger);
}

/** Numbers that are shown; the newest of them. */
const MAX_SHOWN = 60;

/** An array of numbers that grows: the newest marked, where it still does. */
export function Sequence({
  name,
  numbers,
  growing,
}: {
  name: string;
  numbers: readonly number[];
  growing: boolean;
}) {
  const earlier = Math.max(0, numbers.length - MAX_SHOWN);
  return (
    <div>
      <Text size="sm" mb={4}>
        {name}{" "}
        <Text span c="dimmed" inherit>
          · {numbers.length} {numbers.length === 1 ? "number" : "numbers"}
          {earlier > 0 && `, the first ${earlier} not shown`}
        </Text>
      </Text>
      <ol
        className={classes.sequence}
        aria-label={name}
        data-growing={growing || undefined}
        start={earlier + 1}
      >
        {numbers.slice(earlier).map((number, index) => (
          // biome-ignore lint/suspicious/noArrayIndexKey: a number is known by its place alone
          <li key={earlier + index}>{number.toLocaleString()}</li>
        ))}
      </ol>
    </div>
  );
}
