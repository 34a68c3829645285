import { isTerminal, type LiveGoal } from "@dock-gateway/client";
import { Anchor, Badge, Group, Text } from "@mantine/core";
import { useEffect, useState, useSyncExternalStore } from "react";
import { Link } from "react-router";
import type { ActionSchemas } from "../api/actions";
import { createGoalsApi } from "../api/goals";
import type { JsonSchema } from "../api/jsonSchema";
import { useFleet, useFleetLive, useFleetTopic } from "../fleet/context";
import { FleetStore } from "../fleet/store";
import { FeedbackCount, GoalDuration, GoalExplanation, GoalStatusBadge } from "../goal/facts";
import { whyNotCancel } from "../goal/words";
import { openStream, streamUrl } from "../stream/stream";
import { CommandErrorAlert } from "../ui/errors";
import { Fact, FactList } from "../ui/Fact";
import { MessageTree } from "../ui/MessageTree";
import { shortest } from "../ui/numbers";
import { ReasonButton } from "../ui/ReasonButton";
import { useCommand } from "../ui/requests";
import { Section } from "../ui/Section";
import { Time } from "../ui/Time";
import classes from "./actions.module.css";

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
      <GoalExplanation goal={goal} />
      <FactList>
        <Fact name="Started">
          <Time value={goal.created_at} />
        </Fact>
        <Fact name="Duration">
          <GoalDuration goal={goal} />
        </Fact>
        <Fact name="Feedback">
          <FeedbackCount count={goal.feedback_count} arrivals={ended ? null : arrivals} />
        </Fact>
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

function Cancel({ goal }: { goal: LiveGoal }) {
  const { http, store } = useFleet();
  const live = useFleetLive();
  const cancel = useCommand(async () =>
    store.addGoals([(await createGoalsApi(http).cancel(goal.goal_id)) as LiveGoal]),
  );
  const reason = whyNotCancel(live, goal, cancel.isPending);
  return (
    <>
      <Group gap="sm">
        <ReasonButton variant="default" size="md" reason={reason} onClick={() => cancel.mutate()}>
          Cancel
        </ReasonButton>
      </Group>
      <CommandErrorAlert command="Cancel" error={cancel.error} onClose={cancel.reset} />
    </>
  );
}

function Messages({ goal, schemas }: { goal: LiveGoal; schemas: ActionSchemas }) {
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

interface Followed {
  goal: LiveGoal | null;
  /** When its latest feedback messages came (ms), oldest first. */
  arrivals: readonly number[];
}

/** A goal with its feedback as it comes: five times a second at most, where all goals have it more rarely. */
function useGoal(goalId: string | null): Followed {
  const [store, setStore] = useState<FleetStore | null>(null);
  useEffect(() => {
    if (goalId === null) return;
    const own = new FleetStore();
    const close = openStream(streamUrl(window.location, { goal_id: goalId, max_rate: "10" }), own);
    setStore(own);
    return () => {
      close();
      setStore(null);
    };
  }, [goalId]);

  const goals = useSyncExternalStore(
    (listener) => store?.subscribe("goals", listener) ?? (() => {}),
    () => store?.get("goals"),
  );
  const fleet = useFleetTopic("goals");
  if (goalId === null) return { goal: null, arrivals: [] };
  return {
    goal: (goals?.get(goalId) ?? fleet.get(goalId) ?? null) as LiveGoal | null,
    arrivals: store?.get("arrivals").get(goalId) ?? [],
  };
}

interface MessageViewProps {
  title: string;
  message: Record<string, unknown>;
  schema: JsonSchema;
  /** Whether more of it is to come. */
  growing: boolean;
}

/** A feedback or a result: whole numbers in a row as a sequence, the rest as a tree. */
function MessageView({ title, message, schema, growing }: MessageViewProps) {
  const entries = Object.entries(message);
  const rest = Object.fromEntries(entries.filter(([, value]) => !isSequence(value)));
  return (
    <>
      {entries.map(
        ([name, value]) =>
          isSequence(value) && <Sequence key={name} name={name} numbers={value} growing={growing} />,
      )}
      {(Object.keys(rest).length > 0 || entries.length === 0) && (
        <div>
          <Text size="sm" mb={4}>
            {title}
          </Text>
          <MessageTree value={rest} schema={schema} label={title} />
        </div>
      )}
    </>
  );
}

function isSequence(value: unknown): value is number[] {
  return Array.isArray(value) && value.length > 0 && value.every(Number.isInteger);
}

/** Numbers that are shown; the newest of them. */
const MAX_SHOWN = 60;

/** An array of numbers that grows: the newest marked, where it still does. */
function Sequence({
  name,
  numbers,
  growing,
}: {
  name: string;
  numbers: readonly number[];
  growing: boolean;
}) {
  const earlier = Math.max(0, numbers.length - MAX_SHOWN);
  return (
    <div>
      <Text size="sm" mb={4}>
        {name}{" "}
        <Text span c="dimmed" inherit>
          · {numbers.length} {numbers.length === 1 ? "number" : "numbers"}
          {earlier > 0 && `, the first ${earlier} not shown`}
        </Text>
      </Text>
      <ol
        className={classes.sequence}
        aria-label={name}
        data-growing={growing || undefined}
        start={earlier + 1}
      >
        {numbers.slice(earlier).map((number, index) => (
          // biome-ignore lint/suspicious/noArrayIndexKey: a number is known by its place alone
          <li key={earlier + index}>{shortest(number, 3)}</li>
        ))}
      </ol>
    </div>
  );
}
