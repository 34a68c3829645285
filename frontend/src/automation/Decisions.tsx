import { Anchor, Badge, Group, Skeleton, Table, Text } from "@mantine/core";
import { Link } from "react-router";
import type { Decision } from "../api/automation";
import { useFleetLive, useNaming } from "../fleet/context";
import { robotPath } from "../fleet/path";
import { Trouble } from "../ui/errors";
import { Section } from "../ui/Section";
import { Time } from "../ui/Time";
import { useZone } from "../ui/zone";
import classes from "./automation.module.css";
import { useDecisions } from "./useAutomation";
import { OUTCOMES, reasonWords } from "./words";

/** The latest decisions as they come. */
export function Decisions() {
  const { data: decisions, error, refetch } = useDecisions();
  const live = useFleetLive();
  return (
    <Section
      title="Latest decisions"
      aside={
        <Text size="sm" c="dimmed" role="status">
          {live ? "Live" : "Not live"}
        </Text>
      }
    >
      <Trouble what="The decisions could not be loaded" error={error} onRetry={() => void refetch()} />
      {decisions === undefined ? (
        error === null && <Skeleton height={80} />
      ) : decisions.length === 0 ? (
        <Text size="sm" c="dimmed">
          Each decision of a rule that is on or in a dry run is listed here, with its reason.
        </Text>
      ) : (
        <DecisionTable decisions={decisions} />
      )}
    </Section>
  );
}

function DecisionTable({ decisions }: { decisions: readonly Decision[] }) {
  return (
    <Table verticalSpacing="xs" horizontalSpacing={8} className={classes.decisions ?? ""}>
      <Table.Thead>
        <Table.Tr>
          <Table.Th className={classes.time}>Time</Table.Th>
          <Table.Th>Robot</Table.Th>
          <Table.Th visibleFrom="sm">Rule</Table.Th>
          <Table.Th>Decision</Table.Th>
        </Table.Tr>
      </Table.Thead>
      <Table.Tbody>
        {decisions.map((decision) => (
          <DecisionRow key={decision.id} decision={decision} />
        ))}
      </Table.Tbody>
    </Table>
  );
}

function DecisionRow({ decision }: { decision: Decision }) {
  const naming = useNaming();
  useZone();
  const { robot, rule_name, outcome, goal_id, at } = decision;
  const { words, color } = OUTCOMES[outcome];
  return (
    <Table.Tr>
      <Table.Td className={`tabular ${classes.time}`}>
        <Time value={at} />
      </Table.Td>
      <Table.Td className={classes.robot}>
        <Anchor component={Link} to={robotPath(robot)} size="sm" underline="always">
          {naming.nameOf(robot)}
        </Anchor>
        <Text size="xs" c="dimmed" hiddenFrom="sm">
          {rule_name}
        </Text>
      </Table.Td>
      <Table.Td visibleFrom="sm">{rule_name}</Table.Td>
      <Table.Td>
        <Group gap="xs">
          <Badge variant="outline" color={color} className={classes.outcome ?? ""}>
            {words}
          </Badge>
          <Text size="sm">{reasonWords(decision)}</Text>
          {goal_id !== null && (
            <Anchor component={Link} to={`/ui/goals/${goal_id}`} size="sm" underline="always">
              See the goal
            </Anchor>
          )}
        </Group>
      </Table.Td>
    </Table.Tr>
  );
}
