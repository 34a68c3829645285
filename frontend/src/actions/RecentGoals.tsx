import type { LiveGoal } from "@dock-gateway/client";
import { Anchor, Button, Table, Text, VisuallyHidden } from "@mantine/core";
import { useEffect, useMemo } from "react";
import { Link } from "react-router";
import type { Json } from "../api/jsonSchema";
import { useFleet, useFleetLive, useFleetTopic } from "../fleet/context";
import { GoalDuration, GoalStatusBadge, OriginBadge } from "../goal/facts";
import { newestFirst } from "../store/goals";
import { Section } from "../ui/Section";
import { Time } from "../ui/Time";
import { useActionsApi } from "./actions";
import classes from "./actions.module.css";
import { spaced, withoutDefaults } from "./form/draft";
import type { MessageShape } from "./form/shapes";

const SHOWN = 10;

/** The goals of an action that are known, newest first; asks the gateway for those that the snapshot leaves out. */
export function useGoalsOf(action: string): LiveGoal[] {
  const { store } = useFleet();
  const api = useActionsApi();
  const live = useFleetLive();
  const goals = useFleetTopic("goals");

  useEffect(() => {
    if (!live) return;
    // What is not answered is not shown; events bring what happens from now on.
    api.goals(action, SHOWN).then(
      (found) => store.addGoals(found as LiveGoal[]),
      () => {},
    );
  }, [api, store, action, live]);

  return useMemo(
    () => newestFirst(goals).filter((goal) => goal.action_name === action) as LiveGoal[],
    [goals, action],
  );
}

interface RecentGoalsProps {
  action: string;
  goals: readonly LiveGoal[];
  /** That of the goal message, and what fills it in; null where there is no form. */
  form: { shape: MessageShape; begin: (message: Json) => void } | null;
}

/** Goals of the past, with what they asked for: to be opened, and to be filled in again. */
export function RecentGoals({ action, goals, form }: RecentGoalsProps) {
  return (
    <Section
      title="Recent goals"
      aside={
        <Anchor component={Link} to={`/ui/goals?action=${encodeURIComponent(action)}`} size="sm">
          All goals of this action
        </Anchor>
      }
    >
      {goals.length === 0 ? (
        <Text size="sm" c="dimmed">
          No goals on this action yet.
        </Text>
      ) : (
        <Table verticalSpacing="xs" horizontalSpacing={8}>
          <Table.Thead>
            <Table.Tr>
              <Table.Th>Started</Table.Th>
              <Table.Th>Status</Table.Th>
              <Table.Th visibleFrom="sm">Origin</Table.Th>
              <Table.Th visibleFrom="sm">Duration</Table.Th>
              <Table.Th visibleFrom="xs">Goal</Table.Th>
              <Table.Th>
                <VisuallyHidden>Use again</VisuallyHidden>
              </Table.Th>
            </Table.Tr>
          </Table.Thead>
          <Table.Tbody>
            {goals.slice(0, SHOWN).map((goal) => (
              <GoalRow key={goal.goal_id} goal={goal} form={form} />
            ))}
          </Table.Tbody>
        </Table>
      )}
    </Section>
  );
}

function GoalRow({ goal, form }: { goal: LiveGoal; form: RecentGoalsProps["form"] }) {
  const message = goal.goal as Json | null;
  const asked =
    message === null ? null : spaced(form === null ? message : withoutDefaults(form.shape, message));
  return (
    <Table.Tr>
      <Table.Td>
        <Anchor component={Link} to={`/ui/goals/${goal.goal_id}`} size="sm" className="tabular">
          <Time value={goal.created_at} />
        </Anchor>
      </Table.Td>
      <Table.Td>
        <GoalStatusBadge status={goal.status} />
      </Table.Td>
      <Table.Td visibleFrom="sm">
        <OriginBadge origin={goal.origin} />
      </Table.Td>
      <Table.Td visibleFrom="sm" className="tabular">
        <GoalDuration goal={goal} />
      </Table.Td>
      <Table.Td visibleFrom="xs" className={classes.message}>
        {asked === null ? (
          <Text size="sm" c="dimmed">
            not known
          </Text>
        ) : (
          <code title={asked.slice(0, 1000)}>{asked.slice(0, 200)}</code>
        )}
      </Table.Td>
      <Table.Td className={classes.use}>
        {message !== null && form !== null && (
          <Button variant="default" size="compact-sm" onClick={() => form.begin(message)}>
            Reuse
          </Button>
        )}
      </Table.Td>
    </Table.Tr>
  );
}
