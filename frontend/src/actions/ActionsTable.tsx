import { type ActionInfo, actionPath, isTerminal, type LiveGoal } from "@dock-gateway/client";
import { Anchor, Badge, Table, Text } from "@mantine/core";
import { useMemo } from "react";
import { Link } from "react-router";
import { useFleetLive, useFleetTopic } from "../fleet/context";
import { GoalStatusBadge } from "../goal/facts";
import { newestFirst } from "../store/goals";
import { Breakable } from "../ui/Fact";
import { Time } from "../ui/Time";
import { sentence } from "../ui/text";
import classes from "./actions.module.css";

/** Actions and how they are used; each leads to its page. */
export function ActionsTable({ actions }: { actions: readonly ActionInfo[] }) {
  const goals = useFleetTopic("goals");
  const byAction = useMemo(() => groupByAction(goals), [goals]);
  return (
    <Table verticalSpacing="sm" horizontalSpacing={8} layout="auto">
      <Table.Thead>
        <Table.Tr>
          <Table.Th>Action</Table.Th>
          <Table.Th visibleFrom="sm">Type</Table.Th>
          <Table.Th>Server</Table.Th>
          <Table.Th visibleFrom="sm">Running</Table.Th>
          <Table.Th visibleFrom="sm">Newest goal</Table.Th>
        </Table.Tr>
      </Table.Thead>
      <Table.Tbody>
        {actions.map((action) => (
          <ActionRow
            key={action.action_name}
            action={action}
            goals={byAction.get(action.action_name) ?? []}
          />
        ))}
      </Table.Tbody>
    </Table>
  );
}

function ActionRow({ action, goals }: { action: ActionInfo; goals: readonly LiveGoal[] }) {
  const live = useFleetLive();
  const running = goals.filter((goal) => !isTerminal(goal.status)).length;
  const newest = goals[0];
  return (
    <Table.Tr>
      <Table.Td className={classes.name}>
        <Anchor component={Link} to={`/ui/actions/${actionPath(action.action_name)}`}>
          <Breakable text={action.action_name} />
        </Anchor>
        <Text size="sm" hiddenFrom="sm" className={classes.type}>
          <Breakable text={action.action_type} />
          {running > 0 && ` · ${running} running`}
        </Text>
        {action.hint !== null && <Text size="sm">{sentence(action.hint)}.</Text>}
      </Table.Td>
      <Table.Td visibleFrom="sm" className={classes.type}>
        <Breakable text={action.action_type} />
      </Table.Td>
      <Table.Td>
        <ServerBadge action={action} live={live} />
      </Table.Td>
      <Table.Td visibleFrom="sm" className="tabular">
        {running === 0 ? "–" : running}
      </Table.Td>
      <Table.Td visibleFrom="sm">
        {newest === undefined ? (
          "–"
        ) : (
          <>
            <GoalStatusBadge status={newest.status} />{" "}
            <Anchor component={Link} to={`/ui/goals/${newest.goal_id}`} size="sm" className="tabular">
              <Time value={newest.created_at} />
            </Anchor>
          </>
        )}
      </Table.Td>
    </Table.Tr>
  );
}

/** Newest first. */
function groupByAction(goals: ReadonlyMap<string, LiveGoal>): ReadonlyMap<string, LiveGoal[]> {
  const groups = new Map<string, LiveGoal[]>();
  for (const goal of newestFirst(goals)) {
    const group = groups.get(goal.action_name);
    if (group === undefined) groups.set(goal.action_name, [goal]);
    else group.push(goal);
  }
  return groups;
}

/** Whether there is an action server, and how it does. */
export function ServerBadge({ action, live }: { action: ActionInfo | null; live: boolean }) {
  const { words, color } = describe(live ? action : null);
  return (
    <Badge component="span" color={color} data-testid="server">
      {words}
    </Badge>
  );
}

function describe(action: ActionInfo | null): { words: string; color: string } {
  if (action === null) return { words: "unknown", color: "gray.7" };
  if (!action.installed) return { words: "package missing", color: "orange" };
  if (!action.available) return { words: "not there", color: "red" };
  if (action.duplicate) return { words: "two servers", color: "red" };
  return action.answering ? { words: "answering", color: "green" } : { words: "silent", color: "orange" };
}
