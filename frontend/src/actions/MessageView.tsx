import { Text } from "@mantine/core";
import type { JsonSchema } from "../api/jsonSchema";
import { MessageTree } from "../ui/MessageTree";
import { Sequence } from "./Sequence";

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
