import { isTerminal } from "@dock-gateway/client";
import { Anchor, Badge, Group, Stack, Text } from "@mantine/core";
import { useState } from "react";
import { Link } from "react-router";
import { batteryIn, summarize } from "../battery/words";
import { FeedbackCount, GoalDuration, GoalExplanation, GoalStatusBadge } from "../goal/facts";
import { goalName } from "../goal/words";
import { useLive, useTopic, useTopicPart } from "../store/context";
import type { GoalCourse } from "../store/goals";
import { Fact, FactList } from "../ui/Fact";
import { Time } from "../ui/Time";
import classes from "./docking.module.css";
import { StageTimeline } from "./StageTimeline";

/** The goal that runs, or how the last one ended. */
export function GoalPanel({ goal }: { goal: GoalCourse }) {
  const live = useLive();
  const ended = isTerminal(goal.status);
  const retries = goal.retries ?? 0;
  return (
    <Stack gap="sm">
      <Group gap="xs">
        <Text fw={600}>
          {ended ? "Last goal" : "Running goal"}: {goalName(goal)}
        </Text>
        <span aria-live="polite">
          <GoalStatusBadge status={goal.status} testId="goal-status" />
        </span>
        {goal.stalled && !ended && <Badge color="orange">stalled</Badge>}
        {retries > 0 && (
          <Badge color="orange" data-testid="retries">
            {retries === 1 ? "1 retry" : `${retries} retries`}
          </Badge>
        )}
        {goal.origin === "external" && (
          <Badge color="grape" variant="outline">
            sent by someone else
          </Badge>
        )}
        {!live && <Badge color="gray.7">Not live</Badge>}
      </Group>
      <StageTimeline goal={goal} />
      <GoalExplanation goal={goal} />
      <FactList wide>
        <Fact name="Started">
          <Time value={goal.created_at} />
        </Fact>
        <Fact name="Duration">
          <GoalDuration goal={goal} />
        </Fact>
        <Fact name="Feedback">
          <FeedbackWords goal={goal} />
        </Fact>
        <BatteryFact goalId={goal.goal_id} />
      </FactList>
      <FeedbackLog goalId={goal.goal_id} />
      <Anchor component={Link} to={`/ui/goals/${goal.goal_id}`} size="sm" underline="always">
        Goal details
      </Anchor>
    </Stack>
  );
}

/** Re-rendered with each message that is shown, and nothing else is. */
function FeedbackWords({ goal }: { goal: GoalCourse }) {
  const count = useTopicPart("goals", (goals) => goals.get(goal.goal_id)?.feedback_count ?? 0);
  const arrivals = useTopicPart("arrivals", (all) => all.get(goal.goal_id) ?? NONE);
  const dropped = useTopic("dropped");
  const unread = useTopic("unread");
  return (
    <>
      <FeedbackCount count={count} arrivals={isTerminal(goal.status) ? null : arrivals} />
      {dropped > 0 && ` (${dropped} skipped: this page was too slow)`}
      {unread > 0 && ` (${unread} not read: too large or too fast)`}
    </>
  );
}

const NONE: readonly number[] = [];

function BatteryFact({ goalId }: { goalId: string }) {
  const final = useTopicPart("goals", (goals) => batteryIn(goals.get(goalId)?.result, "final_battery_state"));
  const told = useTopicPart(
    "goals",
    (goals) => batteryIn(goals.get(goalId)?.feedback, "current_battery_state") !== null,
  );
  if (final !== null) return <Fact name="Battery at the end">{summarize(final)}</Fact>;
  return (
    told && (
      <Fact name="Battery in feedback">
        <BatteryWords goalId={goalId} />
      </Fact>
    )
  );
}

function BatteryWords({ goalId }: { goalId: string }) {
  return useTopicPart("goals", (goals) => {
    const battery = batteryIn(goals.get(goalId)?.feedback, "current_battery_state");
    return battery === null ? "" : summarize(battery);
  });
}

/** The latest feedback of a goal as it comes, newest first; folded until somebody wants to read it. */
function FeedbackLog({ goalId }: { goalId: string }) {
  const [open, setOpen] = useState(false);
  const any = useTopicPart("feedback", (events) => events.some((event) => event.goal_id === goalId));
  if (!any) return null;
  return (
    <details
      className={classes.log}
      data-testid="feedback-log"
      onToggle={(event) => setOpen(event.currentTarget.open)}
    >
      <summary>Feedback as it comes</summary>
      {open && <Messages goalId={goalId} />}
    </details>
  );
}

function Messages({ goalId }: { goalId: string }) {
  const messages = useTopic("feedback").filter((event) => event.goal_id === goalId);
  return (
    <ol>
      {messages.map(({ id, time, feedback }) => (
        <li key={id}>
          <Text span size="sm" c="dimmed" className="tabular">
            <Time value={time} />
          </Text>{" "}
          <Text span size="sm" className="tabular">
            {wordsOf(feedback)}
          </Text>
        </li>
      ))}
    </ol>
  );
}

/** A battery state in words; the fields of any other feedback as JSON. */
function wordsOf(feedback: object): string {
  const battery = batteryIn(feedback, "current_battery_state");
  return battery === null ? JSON.stringify(feedback) : summarize(battery);
}
