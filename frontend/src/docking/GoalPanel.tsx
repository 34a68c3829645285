import { Alert, Anchor, Badge, Group, Stack, Text } from "@mantine/core";
import { Link } from "react-router";
import type { Verb } from "../api/client";
import { summarize } from "../battery/words";
import { GoalStatusBadge } from "../goals/GoalStatusBadge";
import { useAtTime } from "../store/clock";
import { useLive, useTopic, useTopicPart } from "../store/context";
import { type GoalCourse, isTerminal } from "../store/goals";
import { useVerbOf } from "../store/verbs";
import { Fact, FactList } from "../ui/Fact";
import { sentence } from "../ui/sentence";
import { Time } from "../ui/Time";
import { formatDuration } from "../ui/time";
import { FeedbackLog } from "./FeedbackLog";
import { advice, meaning } from "./goalWords";
import { rate } from "./rate";
import { StageTimeline } from "./StageTimeline";

/** The goal that runs, or how the last one ended. */
export function GoalPanel({ goal }: { goal: GoalCourse }) {
  const live = useLive();
  const verb = useVerbOf()(goal);
  const ended = isTerminal(goal.status);
  const retries = goal.retries ?? 0;
  return (
    <Stack gap="sm">
      <Group gap="xs">
        <Text fw={600}>
          {ended ? "Last goal" : "Running goal"}: {verb}
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
      <Explanation goal={goal} verb={verb} />
      <FactList wide>
        <Fact name="Started">
          <Time value={goal.created_at} />
        </Fact>
        <Elapsed goal={goal} />
        <Fact name="Feedback">
          <FeedbackWords goal={goal} />
        </Fact>
        <BatteryFact goalId={goal.goal_id} />
      </FactList>
      <FeedbackLog goalId={goal.goal_id} />
      <Anchor component={Link} to={`/ui/goals/${goal.goal_id}`} size="sm" underline="always">
        All of this goal
      </Anchor>
    </Stack>
  );
}

/** Why it stands as it does: an alert where something is wrong, a quiet line otherwise. */
function Explanation({ goal, verb }: { goal: GoalCourse; verb: Verb }) {
  const wrong = goal.error !== null || goal.stalled || goal.status === "lost";
  if (!wrong) {
    return (
      <Text size="sm" c="dimmed">
        {meaning(goal, verb)}
      </Text>
    );
  }
  const hint = advice(goal);
  return (
    <Alert color={goal.status === "canceled" || goal.stalled ? "orange" : "red"} title={meaning(goal, verb)}>
      {goal.error !== null && <Text size="sm">{sentence(goal.error.detail)}</Text>}
      {hint !== null && <Text size="sm">{hint}</Text>}
      {goal.error !== null && <Text size="sm">Code: {goal.error.code}</Text>}
    </Alert>
  );
}

function Elapsed({ goal }: { goal: GoalCourse }) {
  const live = useLive();
  const start = Date.parse(goal.created_at);
  const words = useAtTime((now) => formatDuration(now - start));
  if (goal.finished_at !== null) {
    return <Fact name="Took">{formatDuration(Date.parse(goal.finished_at) - start)}</Fact>;
  }
  return <Fact name="Elapsed">{live ? words : "not live"}</Fact>;
}

/** How many feedback messages have come, and how fast; rendered anew with each that is shown, and nothing else is. */
function FeedbackWords({ goal }: { goal: GoalCourse }) {
  const count = useTopicPart("goals", (goals) => goals.get(goal.goal_id)?.feedback_count ?? 0);
  const arrivals = useTopicPart("arrivals", (all) => all.get(goal.goal_id) ?? NONE);
  const dropped = useTopic("dropped");
  const perSecond = useAtTime((now) => rate(arrivals, now)?.toFixed(1) ?? "");
  return [
    `${count} ${count === 1 ? "message" : "messages"}`,
    perSecond !== "" && !isTerminal(goal.status) && `, ${perSecond} Hz`,
    dropped > 0 && ` (${dropped} skipped: this page was too slow)`,
  ];
}

const NONE: readonly number[] = [];

function BatteryFact({ goalId }: { goalId: string }) {
  const final = useTopicPart("goals", (goals) => goals.get(goalId)?.result?.final_battery_state);
  const told = useTopicPart("goals", (goals) => goals.get(goalId)?.feedback != null);
  if (final !== undefined) return <Fact name="Battery at the end">{summarize(final)}</Fact>;
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
    const feedback = goals.get(goalId)?.feedback;
    return feedback == null ? "" : summarize(feedback.current_battery_state);
  });
}
