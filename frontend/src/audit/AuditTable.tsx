import { Badge, Table, Text } from "@mantine/core";
import { Link } from "react-router";
import type { AuditRecord } from "../api/audit";
import { useNaming } from "../fleet/context";
import { codeWords } from "../goal/words";
import { goalPath } from "../goals/GoalsTable";
import { Breakable } from "../ui/Fact";
import { Time } from "../ui/Time";
import classes from "./audit.module.css";
import { GOAL_ID, type Outcome } from "./filter";
import { OUTCOME_WORDS, whatWords } from "./words";

const COLORS: Record<Outcome, string> = { done: "gray", refused: "orange", failed: "red" };

/** Records, a row each. */
export function AuditTable({ records }: { records: readonly AuditRecord[] }) {
  return (
    <Table verticalSpacing="xs" horizontalSpacing={8} className={classes.table ?? ""}>
      <Table.Thead>
        <Table.Tr>
          <Table.Th>Time</Table.Th>
          <Table.Th>Who</Table.Th>
          <Table.Th>What</Table.Th>
          <Table.Th visibleFrom="sm">About</Table.Th>
          <Table.Th>Outcome</Table.Th>
          <Table.Th visibleFrom="md">From</Table.Th>
        </Table.Tr>
      </Table.Thead>
      <Table.Tbody>
        {records.map((record) => (
          <Table.Tr key={record.sequence}>
            <Table.Td className={classes.time}>
              <Time value={record.at} />
            </Table.Td>
            <Table.Td className={classes.name}>
              <Who record={record} />
            </Table.Td>
            <Table.Td title={record.what}>
              {whatWords(record.what)}
              <Text size="sm" component="div" hiddenFrom="sm">
                <About record={record} />
              </Text>
            </Table.Td>
            <Table.Td visibleFrom="sm" className={classes.name}>
              <About record={record} />
            </Table.Td>
            <Table.Td>
              <Badge variant="light" color={COLORS[record.outcome]} title={`Status ${record.status}`}>
                {OUTCOME_WORDS[record.outcome]}
              </Badge>
              {record.code !== null && <Text size="sm">{codeWords(record.code)}</Text>}
            </Table.Td>
            <Table.Td visibleFrom="md" className={classes.name}>
              {record.client}
            </Table.Td>
          </Table.Tr>
        ))}
      </Table.Tbody>
    </Table>
  );
}

function Who({ record: { principal, role } }: { record: AuditRecord }) {
  if (principal === null) return <Text size="sm">{role === null ? "Unknown" : "Anyone (no token)"}</Text>;
  return (
    <>
      <Text size="sm" fw={600}>
        {principal}
      </Text>
      <Text size="sm">{role}</Text>
    </>
  );
}

/** Which robot, goal or thing. */
function About({ record: { robot, goal_id, action_name, subject } }: { record: AuditRecord }) {
  const naming = useNaming();
  return (
    <>
      {robot?.split(",").map((name) => (
        <div key={name}>{naming.fullNameOf(name)}</div>
      ))}
      {action_name !== null && <Breakable text={action_name} />}
      {goal_id !== null && GOAL_ID.test(goal_id) && (
        <div>
          <Link to={goalPath(goal_id)}>Goal {goal_id.slice(0, 8)}</Link>
        </div>
      )}
      {subject !== null && <div className={classes.subject}>{subject}</div>}
    </>
  );
}
