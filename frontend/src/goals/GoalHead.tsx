import { Anchor, Badge, Code, Group, Stack, Text, Title } from "@mantine/core";
import { Link } from "react-router";
import type { AnyGoal } from "../api/types";
import { SentByRule } from "../automation/links";
import { useFleetLive, useNaming } from "../fleet/context";
import { GoalDuration, GoalStatusBadge, OriginBadge } from "../goal/facts";
import { advice, meaning } from "../goal/words";
import { isTerminal } from "../store/goals";
import { CopyButton } from "../ui/CopyButton";
import { Breakable, Fact, FactList } from "../ui/Fact";
import { Time } from "../ui/Time";
import { sentence } from "../ui/text";
import { NO_FILTER, writeFilter } from "./filter";
import { GoalCommands } from "./GoalCommands";
import classes from "./goalPage.module.css";
import { useWatchTopic } from "./useGoalWatch";

/** What a goal is and how it stands, with what can be done about it. */
export function GoalHead({ goal }: { goal: AnyGoal }) {
  const robot = useNaming().ownerNameOf(goal.action_name);
  const connection = useWatchTopic("connection");
  const ended = isTerminal(goal.status);
  const away = connection !== null && connection.phase !== "live" && connection.phase !== "connecting";
  return (
    <Stack gap="sm">
      <Group gap="xs">
        <Title order={1} size="h3">
          Goal on <Breakable text={goal.action_name} />
        </Title>
        <span aria-live="polite">
          <GoalStatusBadge status={goal.status} testId="goal-status" />
        </span>
        {goal.stalled && !ended && <Badge color="orange">stalled</Badge>}
        {away && <Badge color="gray.7">Not live</Badge>}
      </Group>
      <GoalVerdict goal={goal} />
      <GoalCommands goal={goal} />
      <div className={classes.id}>
        <Code>{goal.goal_id}</Code>
        <CopyButton value={goal.goal_id} what="the goal id" />
      </div>
      <FactList wide>
        <Fact name="Started">
          <Time value={goal.created_at} />
        </Fact>
        <Fact name="Duration">
          <GoalDuration goal={goal} />
        </Fact>
        {goal.finished_at !== null && (
          <Fact name="Ended">
            <Time value={goal.finished_at} />
          </Fact>
        )}
        {goal.retries !== null && <Fact name="Retries">{goal.retries}</Fact>}
        <Fact name="Origin">
          {goal.origin === "automation" ? (
            <SentByRule goalId={goal.goal_id} />
          ) : (
            <OriginBadge origin={goal.origin} />
          )}
        </Fact>
        {robot !== null && <Fact name="Robot">{robot}</Fact>}
        <Fact name="Action">
          <Anchor
            component={Link}
            to={`/ui/goals?${writeFilter({ ...NO_FILTER, actions: [goal.action_name] })}`}
          >
            <Breakable text={goal.action_name} />
          </Anchor>
        </Fact>
        <Fact name="Type">
          <Breakable text={goal.action_type} />
        </Fact>
      </FactList>
    </Stack>
  );
}

/** First what became of a goal, why, and how long it took; then what to do. */
export function GoalVerdict({ goal }: { goal: AnyGoal }) {
  const { error, status } = goal;
  const hint = advice(goal);
  const live = useFleetLive();
  const ended = isTerminal(status);
  return (
    <div className={classes.verdict} data-tone={toneOf(goal)} data-testid="verdict">
      <Text fz="lg" fw={600}>
        {meaning(goal).replace(/\.$/, "")}
        <Text span inherit fw={400} className="tabular">
          {ended ? ", after " : live ? ", for " : ", "}
          <GoalDuration goal={goal} />
          {!ended && live && " so far"}
        </Text>
      </Text>
      {error !== null && status === "canceled" && <Text size="sm">{sentence(error.detail)}.</Text>}
      {hint !== null && (
        <Text size="sm">
          <strong>What to do:</strong> {hint}
        </Text>
      )}
      {error !== null && status !== "canceled" && (
        <details>
          <summary>Details</summary>
          <Text size="sm">{sentence(error.detail)}</Text>
          <Text size="sm">Code: {error.code}</Text>
        </details>
      )}
    </div>
  );
}

/** Only what needs somebody has a colour. */
function toneOf({ status, stalled, error }: AnyGoal): "bad" | "warn" | undefined {
  if (status === "canceled") return undefined;
  if (status === "lost" || error !== null) return "bad";
  return stalled ? "warn" : undefined;
}
