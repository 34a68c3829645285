import { Code, Group, Stack, Text, Title } from "@mantine/core";
import { CopyButton } from "./CopyButton";
import classes from "./ui.module.css";

interface JsonBlockProps {
  title: string;
  value: unknown;
  /** What to say instead when there is no value. */
  absent: string;
}

/** A message as JSON, to read and to copy. */
export function JsonBlock({ title, value, absent }: JsonBlockProps) {
  const text = JSON.stringify(value, null, 2);
  const empty = value === null || value === undefined;
  return (
    <Stack gap={4}>
      <Group justify="space-between">
        <Title order={3} size="h5">
          {title}
        </Title>
        {!empty && <CopyButton value={text} what={`${title} as JSON`} />}
      </Group>
      {empty ? (
        <Text size="sm" c="dimmed">
          {absent}
        </Text>
      ) : (
        // Scrolls, so it has to be reachable by keyboard.
        <Code block className={classes.json} tabIndex={0} role="region" aria-label={`${title} as JSON`}>
          {text}
        </Code>
      )}
    </Stack>
  );
}
