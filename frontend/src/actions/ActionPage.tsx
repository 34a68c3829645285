import { type ActionInfo, isTerminal, type LiveGoal } from "@dock-gateway/client";
import { Alert, Anchor, Group, Skeleton, Stack, Text, Title } from "@mantine/core";
import { useMemo, useRef, useState } from "react";
import { Link, useParams } from "react-router";
import type { ActionSchemas } from "../api/actions";
import type { Json } from "../api/jsonSchema";
import { useFleet, useFleetLive } from "../fleet/context";
import { CommandErrorAlert } from "../ui/errors";
import { Section, usePageTitle } from "../ui/Section";
import { sentence } from "../ui/text";
import { ServerBadge } from "./ActionsTable";
import { useActions, useSchemas } from "./actions";
import classes from "./actions.module.css";
import { shapeOf } from "./form/shapes";
import { GoalForm } from "./GoalForm";
import { GoalWatch } from "./GoalWatch";
import { RecentGoals, useGoalsOf } from "./RecentGoals";
import { startingMessage, useDraft } from "./useDraft";

/** One action, by the name in the address: a goal to send, to watch and to cancel. */
export default function ActionPage() {
  const { "*": path = "" } = useParams();
  const name = `/${path.replace(/\/+$/, "")}`;
  usePageTitle(name);
  return <Page key={name} name={name} />;
}

function Page({ name }: { name: string }) {
  const live = useFleetLive();
  const { data, error, refetch } = useActions();
  const now = data?.find((action) => action.action_name === name) ?? null;
  // The form stays when the action server goes away.
  const [known, setKnown] = useState<ActionInfo | null>(null);
  if (now !== null && now !== known) setKnown(now);
  if (now === null && data !== undefined && known?.available === true)
    setKnown({ ...known, available: false });

  return (
    <Stack gap="md">
      <div>
        <Anchor component={Link} to="/ui/actions" size="sm">
          All actions
        </Anchor>
        <Group gap="sm" mt={4}>
          <Title order={1} size="h3" className={classes.name}>
            {name}
          </Title>
          <span role="status">
            <ServerBadge action={known} live={live} />
          </span>
        </Group>
        {known !== null && <Text className={classes.type}>{known.action_type}</Text>}
      </div>
      <CommandErrorAlert command="Looking for the action" error={error} onClose={() => void refetch()} />
      {known === null && data !== undefined && <NotThere name={name} />}
      {known === null && data === undefined && error === null && <Loading />}
      {known?.installed === false && <Missing action={known} />}
      {known?.installed === true ? <Goals action={known} /> : <Others name={name} />}
    </Stack>
  );
}

/** The form, the goal to watch, and those of the past. */
function Goals({ action }: { action: ActionInfo }) {
  const { data, error, refetch } = useSchemas(action.action_type);
  return (
    <>
      <CommandErrorAlert command="Reading the interface" error={error} onClose={() => void refetch()} />
      {data === undefined ? <Loading /> : <WithForm action={action} schemas={data} />}
    </>
  );
}

function WithForm({ action, schemas }: { action: ActionInfo; schemas: ActionSchemas }) {
  const name = action.action_name;
  const { store } = useFleet();
  const shape = useMemo(() => shapeOf(schemas.goal), [schemas]);
  const draft = useDraft(name, shape, startingMessage(action.action_type));
  const goals = useGoalsOf(name);
  const [sent, setSent] = useState<string | null>(null);
  const top = useRef<HTMLDivElement>(null);
  const reuse = (message: Json) => {
    draft.begin(message);
    top.current?.focus({ preventScroll: true });
    top.current?.scrollIntoView();
  };
  const newest = goals.find((goal) => !isTerminal(goal.status)) ?? goals[0] ?? null;

  return (
    <>
      <div className={classes.columns} ref={top} tabIndex={-1}>
        <GoalForm
          action={action}
          shape={shape}
          draft={draft}
          onSent={(goal: LiveGoal) => {
            store.addGoals([goal as LiveGoal]);
            setSent(goal.goal_id);
          }}
        />
        <div className={classes.watch}>
          <GoalWatch goalId={sent ?? newest?.goal_id ?? null} schemas={schemas} />
        </div>
      </div>
      <RecentGoals action={name} goals={goals} form={{ shape, begin: reuse }} />
    </>
  );
}

/** What happened on an action that no goal can be sent to from here. */
function Others({ name }: { name: string }) {
  const goals = useGoalsOf(name);
  return goals.length === 0 ? null : <RecentGoals action={name} goals={goals} form={null} />;
}

function NotThere({ name }: { name: string }) {
  return (
    <Alert color="orange" title={`No action server for ${name}`}>
      <Text size="sm">
        Start its action server: this page notices within seconds. Where it runs already, look whether it is
        in the same ROS domain as the gateway, and whether its name and namespace are these.
      </Text>
    </Alert>
  );
}

function Missing({ action }: { action: ActionInfo }) {
  return (
    <Alert color="orange" title={`The gateway cannot speak to ${action.action_name}`}>
      <Text size="sm">
        {sentence(action.hint ?? "Its interface package is not installed")}, where the gateway runs, and start
        the gateway again.
      </Text>
    </Alert>
  );
}

function Loading() {
  return (
    <Section title="Goal">
      <Stack gap="sm" role="status" aria-busy="true" aria-label="The form is loading">
        <Skeleton height={60} />
        <Skeleton height={60} />
        <Skeleton height={42} width={160} />
      </Stack>
    </Section>
  );
}
