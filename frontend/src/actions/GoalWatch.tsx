import { Alert, Anchor, Badge, Button, Group, Text } from "@mantine/core";
import { useId } from "react";
import { Link } from "react-router";
import type { ActionSchemas } from "../api/actions";
import type { AnyGoal, Goal } from "../api/types";
import { advice } from "../docking/goalWords";
import { rate } from "../docking/rate";
import { useFleet, useFleetLive } from "../fleet/context";
import { GoalStatusBadge } from "../goals/GoalStatusBadge";
import { useGatewayNow } from "../store/clock";
import { isTerminal } from "../store/goals";
import { CommandErrorAlert } from "../ui/CommandErrorAlert";
import { Fact, FactList } from "../ui/Fact";
import { Section } from "../ui/Section";
import { sentence } from "../ui/sentence";
import { Time } from "../ui/Time";
import { formatDuration } from "../ui/time";
import { useCommand } from "../ui/useCommand";
import { MessageView } from "./MessageView";
import { useActionsApi } from "./useActions";
import { useGoal } from "./useGoal";
import { meaning, whyNotCancel } from "./words";

/** A goal of the action as it goes: the one that was sent from here, or the newest. */
export function GoalWatch({ goalId, schemas }: { goalId: string | null; schemas: ActionSchemas }) {
  const { goal, arrivals } = useGoal(goalId);
  if (goal === null) {
    return (
      <Section title="Goal to watch">
        <Text size="sm" c="dimmed">
          Send a goal: its feedback appears here as it comes, and its result in the end. A goal that someone
          else sends to this action, such as <em>ros2 action send_goal</em>, appears here as well.
        </Text>
      </Section>
    );
  }
  const ended = isTerminal(goal.status);
  return (
    <Section
      title={ended ? "Last goal" : "Running goal"}
      aside={
        <Group gap="xs">
          <span aria-live="polite">
            <GoalStatusBadge status={goal.status} testId="goal-status" />
          </span>
          {goal.stalled && !ended && <Badge color="orange">stalled</Badge>}
          {goal.origin === "external" && (
            <Badge color="grape" variant="outline">
              sent by someone else
            </Badge>
          )}
        </Group>
      }
    >
      <Explanation goal={goal} />
      <FactList>
        <Fact name="Started">
          <Time value={goal.created_at} />
        </Fact>
        <Elapsed goal={goal} />
        <Feedback goal={goal} arrivals={arrivals} />
        {goal.stage !== null && (
          <Fact name="Stage">
            {goal.stage}
            {goal.retries !== null && goal.retries > 0 && `, retry ${goal.retries}`}
          </Fact>
        )}
        <Fact name="Goal">
          <Anchor component={Link} to={`/ui/goals/${goal.goal_id}`}>
            {goal.goal_id.slice(0, 8)}
          </Anchor>
        </Fact>
      </FactList>
      {!ended && <Cancel goal={goal} />}
      <Messages goal={goal} schemas={schemas} />
    </Section>
  );
}

/** Why it stands as it does: an alert where something is wrong, a quiet line otherwise. */
function Explanation({ goal }: { goal: AnyGoal }) {
  if (goal.error === null && !goal.stalled && goal.status !== "lost") {
    return (
      <Text size="sm" c="dimmed">
        {meaning(goal)}
      </Text>
    );
  }
  const hint = advice(goal as Goal);
  return (
    <Alert color={goal.status === "canceled" || goal.stalled ? "orange" : "red"} title={meaning(goal)}>
      {goal.error !== null && <Text size="sm">{sentence(goal.error.detail)}</Text>}
      {hint !== null && <Text size="sm">{hint}</Text>}
      {goal.error !== null && <Text size="sm">Code: {goal.error.code}</Text>}
    </Alert>
  );
}

function Elapsed({ goal }: { goal: AnyGoal }) {
  const now = useGatewayNow();
  const live = useFleetLive();
  const start = Date.parse(goal.created_at);
  if (goal.finished_at !== null) {
    return <Fact name="Took">{formatDuration(Date.parse(goal.finished_at) - start)}</Fact>;
  }
  return <Fact name="Elapsed">{live ? formatDuration(now - start) : "not live"}</Fact>;
}

function Feedback({ goal, arrivals }: { goal: AnyGoal; arrivals: readonly number[] }) {
  const now = useGatewayNow();
  const perSecond = isTerminal(goal.status) ? null : rate(arrivals, now);
  return (
    <Fact name="Feedback">
      {goal.feedback_count} {goal.feedback_count === 1 ? "message" : "messages"}
      {perSecond !== null && `, ${perSecond.toFixed(1)} Hz`}
    </Fact>
  );
}

function Cancel({ goal }: { goal: AnyGoal }) {
  const { store } = useFleet();
  const api = useActionsApi();
  const live = useFleetLive();
  const reasonId = useId();
  const cancel = useCommand(async () => store.addGoals([(await api.cancel(goal.goal_id)) as Goal]));
  const reason = whyNotCancel(live, goal, cancel.isPending);
  return (
    <>
      <Group gap="sm">
        <Button
          variant="default"
          size="md"
          disabled={reason !== null}
          aria-describedby={reasonId}
          onClick={() => cancel.mutate()}
        >
          Cancel
        </Button>
        <Text size="sm" c="dimmed" id={reasonId} role="status">
          {reason}
        </Text>
      </Group>
      <CommandErrorAlert command="Cancel" error={cancel.error} onClose={cancel.reset} />
    </>
  );
}

function Messages({ goal, schemas }: { goal: AnyGoal; schemas: ActionSchemas }) {
  const ended = isTerminal(goal.status);
  if (ended && goal.result !== null) {
    return <MessageView title="Result" message={goal.result} schema={schemas.result} growing={false} />;
  }
  if (goal.feedback !== null) {
    return (
      <MessageView
        title="Latest feedback"
        message={goal.feedback}
        schema={schemas.feedback}
        growing={!ended}
      />
    );
  }
  return (
    <Text size="sm" c="dimmed">
      {ended ? "There was no feedback, and there is no result." : "No feedback yet."}
    </Text>
  );
}
