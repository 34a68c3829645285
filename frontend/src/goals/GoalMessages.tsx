import { isTerminal, type LiveGoal } from "@dock-gateway/client";
import { Group, Stack, Text, Title } from "@mantine/core";
import { useSchemas } from "../actions/actions";
import type { JsonSchema } from "../api/jsonSchema";
import { CopyButton } from "../ui/CopyButton";
import { MessageTree } from "../ui/MessageTree";
import { Section } from "../ui/Section";

/** What was asked, and what came of it. */
export function GoalMessages({ goal }: { goal: LiveGoal }) {
  const schemas = useSchemas(goal.action_type).data;
  return (
    <Section title="Goal and result" help="api#a-goal">
      <NamedMessage
        title="Goal"
        value={goal.goal}
        schema={schemas?.goal}
        absent={
          goal.origin === "external"
            ? "Unknown: ROS does not publish the goal messages of other clients."
            : "Unknown."
        }
      />
      <NamedMessage
        title="Result"
        value={goal.result}
        schema={schemas?.result}
        absent={isTerminal(goal.status) ? "There is no result." : "The goal has not ended."}
      />
    </Section>
  );
}

interface NamedMessageProps {
  title: string;
  value: unknown;
  schema: JsonSchema | undefined;
  /** What to say where there is none. */
  absent: string;
}

/** A message as a tree under its name, to copy as JSON. */
export function NamedMessage({ title, value, schema, absent }: NamedMessageProps) {
  const missing = value === null || value === undefined;
  return (
    <Stack gap={6}>
      <Group justify="space-between" gap="xs">
        <Title order={3} size="h5">
          {title}
        </Title>
        {!missing && (
          <CopyButton value={JSON.stringify(value, null, 2)} what={`${title}, as JSON`} label="Copy JSON" />
        )}
      </Group>
      {missing ? (
        <Text size="sm" c="dimmed">
          {absent}
        </Text>
      ) : (
        <MessageTree value={value} schema={schema} label={title} />
      )}
    </Stack>
  );
}
