import { Group, Paper, Stack, Text } from "@mantine/core";
import type { ReactNode } from "react";

interface EmptyProps {
  title: string;
  /** What will be here, and how it comes. */
  children: ReactNode;
  /** Buttons that fill a form with an example, or a command to type. */
  examples?: ReactNode;
  /** Inside of a card, which has a frame already. */
  inside?: boolean;
}

/** What stands where a list has nothing yet: what it is for, and something to start from. */
export function Empty({ title, children, examples, inside = false }: EmptyProps) {
  return (
    <Paper withBorder={!inside} radius="md" p={inside ? 0 : { base: "md", sm: "lg" }} data-testid="empty">
      <Stack gap="sm">
        <Text fw={600}>{title}</Text>
        <Text size="sm" c="dimmed" maw="44rem">
          {children}
        </Text>
        {examples !== undefined && <Group gap="xs">{examples}</Group>}
      </Stack>
    </Paper>
  );
}
