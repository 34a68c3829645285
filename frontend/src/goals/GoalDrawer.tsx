import { Badge, CloseButton, Code, Drawer, Group, Stack, Text, Title } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { type CommandError, toCommandError } from "../api/errors";
import type { Goal } from "../api/types";
import { meaning } from "../docking/goalWords";
import { useServices, useTopic } from "../store/context";
import { isTerminal } from "../store/goals";
import { useVerbOf } from "../store/verbs";
import { CopyButton } from "../ui/CopyButton";
import { Fact, FactList } from "../ui/Fact";
import { JsonBlock } from "../ui/JsonBlock";
import { sentence } from "../ui/sentence";
import { Time } from "../ui/Time";
import { GoalStatusBadge } from "./GoalStatusBadge";
import classes from "./goals.module.css";

/** A goal in full: what was asked, the latest feedback, the result. */
export function GoalDrawer({ goalId, onClose }: { goalId: string | null; onClose: () => void }) {
  return (
    <Drawer.Root opened={goalId !== null} onClose={onClose} position="right" size="lg">
      <Drawer.Overlay className={classes.belowHeader} />
      <Drawer.Content aria-label="Goal" classNames={{ inner: classes.belowHeader, content: classes.drawer }}>
        <Drawer.Body pt="md">
          <Group justify="space-between" mb="sm">
            <Title order={2} size="h4">
              Goal
            </Title>
            <CloseButton aria-label="Close the details" onClick={onClose} data-autofocus />
          </Group>
          {goalId !== null && <GoalDetails goalId={goalId} />}
        </Drawer.Body>
      </Drawer.Content>
    </Drawer.Root>
  );
}

function GoalDetails({ goalId }: { goalId: string }) {
  const { gateway } = useServices();
  const verbOf = useVerbOf();
  const known = useTopic("goals").get(goalId);
  const verb = known === undefined ? "dock" : verbOf(known);
  // The stream leaves some fields out; the goal itself has them all. Asked for again when the status changes.
  const query = useQuery<Goal, CommandError>({
    queryKey: ["goal", verb, goalId, known?.status],
    queryFn: () =>
      gateway.goal(verb, goalId).catch((error: unknown) => {
        throw toCommandError(error);
      }),
    placeholderData: (previous) => previous,
  });
  const goal = known && !isTerminal(known.status) ? known : (query.data ?? known);
  if (goal === undefined) return <Text>{query.error?.message ?? "Loading …"}</Text>;

  return (
    <Stack gap="md">
      <div className={classes.id}>
        <Code>{goal.goal_id}</Code>
        <CopyButton value={goal.goal_id} what="the goal id" />
      </div>
      <Text component="div" size="sm">
        <GoalStatusBadge status={goal.status} /> {meaning(goal, verb)}
      </Text>
      {goal.error !== null && (
        <Text size="sm">
          {sentence(goal.error.detail)} <Code>{goal.error.code}</Code>
        </Text>
      )}
      {query.error !== null && (
        <Text size="sm" c="dimmed">
          Not all of it could be loaded: {query.error.title.toLowerCase()}. This is what the page knows.
        </Text>
      )}
      <FactList>
        <Fact name="Origin">
          <Badge variant="outline" color={goal.origin === "external" ? "grape" : "blue"}>
            {goal.origin}
          </Badge>
        </Fact>
        <Fact name="Started">
          <Time value={goal.created_at} />
        </Fact>
        <Fact name="Ended">{goal.finished_at === null ? "–" : <Time value={goal.finished_at} />}</Fact>
        {goal.stage !== null && <Fact name="Stage">{goal.stage}</Fact>}
        {goal.retries !== null && <Fact name="Retries">{goal.retries}</Fact>}
        <Fact name="Feedback messages">{goal.feedback_count}</Fact>
        <Fact name="Action">{goal.action_name}</Fact>
        <Fact name="Type">{goal.action_type}</Fact>
      </FactList>
      <JsonBlock
        title="Goal message"
        value={goal.goal}
        absent={
          goal.origin === "external" ? "Not known: ROS does not tell what others asked for." : "Not known."
        }
      />
      <JsonBlock title="Latest feedback" value={goal.feedback} absent="There was no feedback." />
      <JsonBlock
        title="Result"
        value={goal.result}
        absent={isTerminal(goal.status) ? "There is no result." : "The goal has not ended."}
      />
    </Stack>
  );
}
