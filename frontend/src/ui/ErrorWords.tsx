import { List, Text } from "@mantine/core";
import type { CommandError } from "../api/errors";
import { sentence } from "./sentence";

/** What an error says of itself: what happened, in which fields, what to do about it, and its code. */
export function ErrorWords({ error }: { error: CommandError }) {
  return (
    <>
      <Text size="sm">{sentence(error.detail)}</Text>
      {error.fields.length > 1 && (
        <List size="sm">
          {error.fields.map((field) => (
            <List.Item key={field.path}>
              {field.path}: {field.detail}
            </List.Item>
          ))}
        </List>
      )}
      {error.advice !== null && (
        <Text size="sm" mt={4}>
          {error.advice}
        </Text>
      )}
      <Text size="sm" mt={4}>
        Code: {error.code}
      </Text>
    </>
  );
}
