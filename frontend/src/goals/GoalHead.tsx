import { isTerminal, type LiveGoal, type StopState } from "@dock-gateway/client";
import { Alert, Anchor, Badge, Code, Group, Stack, Text, Title } from "@mantine/core";
import { useState } from "react";
import { Link } from "react-router";
import { useActionsApi, useSchemas } from "../actions/actions";
import { goalExportUrl } from "../api/goals";
import { whyForbidden } from "../api/session";
import { Parts } from "../extension/context";
import { NOT_CONNECTED, useFleetLive, useFleetTopic, useNaming } from "../fleet/context";
import { goalPath, isBelow } from "../fleet/names";
import { GoalDuration, GoalStatusBadge, OriginBadge } from "../goal/facts";
import { advice, goalTitle, meaning, whyNotCancel } from "../goal/words";
import { CopyButton } from "../ui/CopyButton";
import { Dialog, QuestionBar } from "../ui/Dialog";
import { Downloads } from "../ui/Downloads";
import { CommandErrorAlert } from "../ui/errors";
import { Breakable, Fact, FactList } from "../ui/Fact";
import { NOT_MEASURED } from "../ui/messageWords";
import { ReasonButton } from "../ui/ReasonButton";
import { useCommand } from "../ui/requests";
import { Time } from "../ui/Time";
import { sentence } from "../ui/text";
import { goalsPath } from "./filter";
import { NamedMessage } from "./GoalMessages";
import classes from "./goalPage.module.css";
import { useWatched, useWatchTopic } from "./useGoalWatch";

/** What a goal is and how it stands, with what can be done about it. */
export function GoalHead({ goal }: { goal: LiveGoal }) {
  const naming = useNaming();
  const robot = naming.ownerNameOf(goal.action_name);
  const connection = useWatchTopic("connection");
  const ended = isTerminal(goal.status);
  const away = connection !== null && connection.phase !== "live" && connection.phase !== "connecting";
  return (
    <Stack gap="sm">
      <Group gap="xs">
        <Title order={1} size="h3">
          <Breakable text={goalTitle(goal, naming)} />
        </Title>
        <span aria-live="polite">
          <GoalStatusBadge status={goal.status} testId="goal-status" />
        </span>
        {goal.stalled && !ended && <Badge color="orange">stalled</Badge>}
        {away && <Badge color="gray.7">Not live</Badge>}
      </Group>
      <Group gap="md" align="start">
        <div className={classes.words}>
          <GoalVerdict goal={goal} />
        </div>
        <Parts at="goalHead" goal={goal} />
      </Group>
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
          <Group gap="xs">
            <OriginBadge origin={goal.origin} />
            <Parts at="goalOrigin" goal={goal} />
          </Group>
        </Fact>
        {robot !== null && <Fact name="Robot">{robot}</Fact>}
        <Fact name="Action">
          <Anchor component={Link} to={goalsPath({ actions: [goal.action_name] })}>
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
function GoalVerdict({ goal }: { goal: LiveGoal }) {
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
function toneOf({ status, stalled, error }: LiveGoal): "bad" | "warn" | undefined {
  if (status === "canceled") return undefined;
  if (status === "lost" || error !== null) return "bad";
  return stalled ? "warn" : undefined;
}

/** Cancel, send again, share and download. Each says what came of it. */
function GoalCommands({ goal }: { goal: LiveGoal }) {
  const { watch, api } = useWatched();
  const actions = useActionsApi();
  const live = useFleetLive();
  const stop = useFleetTopic("stop");
  const [asking, setAsking] = useState(false);
  const cancel = useCommand(async () => watch.take(await api.cancel(goal.goal_id)));
  const again = useCommand(() => actions.send(goal.action_name, JSON.stringify(goal.goal)));
  const cancelReason = whyNotCancel(live, goal, cancel.isPending);
  const againReason = whyNotAgain(goal, live, stop, again.isPending);
  const send = () => {
    setAsking(false);
    again.mutate();
  };
  return (
    <Stack gap="xs">
      <div className={classes.commands}>
        <ReasonButton variant="default" reason={cancelReason} onClick={() => cancel.mutate()}>
          Cancel
        </ReasonButton>
        <ReasonButton variant="default" reason={againReason} onClick={() => setAsking(true)}>
          Send again …
        </ReasonButton>
        <CopyButton value={window.location.href} what="to this goal" label="Copy link" />
        <Downloads what="this goal" url={(format) => goalExportUrl(goal.goal_id, format)} />
        <Parts at="goalCommands" goal={goal} />
      </div>
      <CommandErrorAlert command="Cancel" error={cancel.error} onClose={cancel.reset} />
      <CommandErrorAlert command="Sending it again" error={again.error} onClose={again.reset} />
      {again.data !== undefined && <SentAgain goal={again.data} onClose={again.reset} />}
      <AskAgain
        goal={goal}
        opened={asking}
        reason={againReason}
        onClose={() => setAsking(false)}
        onSend={send}
      />
    </Stack>
  );
}

function SentAgain({ goal, onClose }: { goal: LiveGoal; onClose: () => void }) {
  return (
    <Alert
      color="green"
      title="Sent again"
      withCloseButton
      closeButtonLabel="Dismiss"
      onClose={onClose}
      role="status"
    >
      <Text component="div" size="sm">
        The answer of the action server: <GoalStatusBadge status={goal.status} />.{" "}
        <Anchor component={Link} to={goalPath(goal.goal_id, goal.action_name)} size="sm">
          Watch the new goal
        </Anchor>
      </Text>
    </Alert>
  );
}

interface AskAgainProps {
  goal: LiveGoal;
  opened: boolean;
  /** Why it cannot be sent any more; null where it can. */
  reason: string | null;
  onClose: () => void;
  onSend: () => void;
}

function AskAgain({ goal, opened, reason, onClose, onSend }: AskAgainProps) {
  const schemas = useSchemas(goal.action_type).data;
  const robot = useNaming().ownerNameOf(goal.action_name) ?? "A robot";
  return (
    <Dialog title="Send this goal again?" opened={opened} onClose={onClose}>
      <Stack gap="md">
        <Text size="sm">
          {robot} may move as soon as {goal.action_name} accepts it. Check that the area is clear.
        </Text>
        <NamedMessage title="Goal" value={goal.goal} schema={schemas?.goal} absent={NOT_MEASURED} />
        <QuestionBar keep="Do not send" onKeep={onClose} go="Send again" onGo={onSend} reason={reason} />
      </Stack>
    </Dialog>
  );
}

function whyNotAgain(goal: LiveGoal, live: boolean, stop: StopState, pending: boolean): string | null {
  const forbidden = whyForbidden("POST /actions/{name}/goals");
  if (forbidden !== null) return forbidden;
  if (goal.goal === null) {
    const reason = goal.origin === "external" ? "ROS does not tell what others asked for" : "it is not known";
    return `The goal's message is missing: ${reason}.`;
  }
  if (!live) return NOT_CONNECTED;
  if (stop.latched && stop.robots.some((robot) => isBelow(goal.action_name, robot))) {
    return "The robot is stopped. Release the stop first.";
  }
  return pending ? "A goal was sent. The action server has not answered yet." : null;
}
