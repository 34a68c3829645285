import { Alert, Anchor, Badge, Group, Stack, Text } from "@mantine/core";
import { Link } from "react-router";
import type { Verb } from "../api/client";
import type { Goal } from "../api/types";
import { summarize } from "../battery/words";
import { GoalStatusBadge } from "../goals/GoalStatusBadge";
import { useGatewayNow } from "../store/clock";
import { useLive, useTopic } from "../store/context";
import { isTerminal } from "../store/goals";
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
export function GoalPanel({ goal }: { goal: Goal }) {
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
        <FeedbackFact goal={goal} />
        <BatteryFact goal={goal} />
      </FactList>
      <FeedbackLog goal={goal} />
      <Anchor component={Link} to={`/ui/goals/${goal.goal_id}`} size="sm" underline="always">
        All of this goal
      </Anchor>
    </Stack>
  );
}

/** Why it stands as it does: an alert where something is wrong, a quiet line otherwise. */
function Explanation({ goal, verb }: { goal: Goal; verb: Verb }) {
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

function Elapsed({ goal }: { goal: Goal }) {
  const now = useGatewayNow();
  const live = useLive();
  const start = Date.parse(goal.created_at);
  if (goal.finished_at !== null) {
    return <Fact name="Took">{formatDuration(Date.parse(goal.finished_at) - start)}</Fact>;
  }
  return <Fact name="Elapsed">{live ? formatDuration(now - start) : "not live"}</Fact>;
}

function FeedbackFact({ goal }: { goal: Goal }) {
  const arrivals = useTopic("arrivals").get(goal.goal_id) ?? [];
  const dropped = useTopic("dropped");
  const now = useGatewayNow();
  const perSecond = isTerminal(goal.status) ? null : rate(arrivals, now);
  return (
    <Fact name="Feedback">
      {goal.feedback_count} {goal.feedback_count === 1 ? "message" : "messages"}
      {perSecond !== null && `, ${perSecond.toFixed(1)} Hz`}
      {dropped > 0 && ` (${dropped} skipped: this page was too slow)`}
    </Fact>
  );
}

function BatteryFact({ goal }: { goal: Goal }) {
  const final = goal.result?.final_battery_state;
  const current = final ?? goal.feedback?.current_battery_state;
  if (current === undefined) return null;
  return <Fact name={final ? "Battery at the end" : "Battery in feedback"}>{summarize(current)}</Fact>;
}
