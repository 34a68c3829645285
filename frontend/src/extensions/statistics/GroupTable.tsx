import { Anchor, Code, Table, Text } from "@mantine/core";
import { memo } from "react";
import { Link } from "react-router";
import { useNaming } from "../../fleet/context";
import { codeWords } from "../../goal/words";
import { Breakable } from "../../ui/Fact";
import { fixed } from "../../ui/numbers";
import { sentence } from "../../ui/text";
import {
  CountLink,
  DurationLink,
  dayWords,
  ENDS,
  goalsLink,
  NumberLink,
  percent,
  RateLink,
  tenths,
} from "./cells";
import type { GoalCounts, GoalGroup, Statistics } from "./requests";
import classes from "./statistics.module.css";
import { GROUPINGS, type Grouping } from "./view";

const ENDS_BUT_SUCCESS = ENDS.filter((status) => status !== "succeeded");
/** Error codes of a row; the table of errors has them all. */
const MAX_ERRORS = 2;

/** A row for each day (the newest first), robot or action. */
export function GroupTable({ statistics: { by, groups } }: { statistics: Statistics }) {
  const naming = useNaming();
  const rows = by === "day" ? [...groups].reverse() : groups;
  return (
    <Table verticalSpacing="xs" horizontalSpacing={8} className={classes.table ?? ""}>
      <GroupHead by={by} />
      <Table.Tbody>
        {rows.map((group) => (
          <GroupRow
            key={group.key}
            by={by}
            group={group}
            displayName={by === "robot" ? naming.displayNameOf(group.key) : null}
          />
        ))}
      </Table.Tbody>
    </Table>
  );
}

function GroupHead({ by }: { by: Grouping }) {
  return (
    <Table.Thead>
      <Table.Tr>
        <Table.Th>{GROUPINGS[by]}</Table.Th>
        <Table.Th className={classes.number}>Ended</Table.Th>
        <Table.Th className={classes.rate}>Success rate</Table.Th>
        {ENDS_BUT_SUCCESS.map((status) => (
          <Table.Th key={status} className={classes.number} visibleFrom="sm">
            {sentence(status)}
          </Table.Th>
        ))}
        <Table.Th className={classes.number}>Median, s</Table.Th>
        <Table.Th className={classes.number} visibleFrom="md">
          90th percentile, s
        </Table.Th>
        <Table.Th className={classes.number} visibleFrom="md">
          Retries
        </Table.Th>
        <Table.Th visibleFrom="lg">Most frequent errors</Table.Th>
      </Table.Tr>
    </Table.Thead>
  );
}

interface GroupRowProps {
  by: Grouping;
  group: GoalGroup;
  /** That of the robot; null where it has none, or the row is no robot's. */
  displayName: string | null;
}

const GroupRow = memo(function GroupRow({ by, group, displayName }: GroupRowProps) {
  const name = by === "day" ? dayWords(group.key) : (displayName ?? <Breakable text={group.key} />);
  return (
    <Table.Tr>
      <Table.Th
        scope="row"
        className={classes.key}
        data-by={by}
        title={displayName === null ? undefined : group.key}
      >
        {group.ended === 0 ? (
          name
        ) : (
          <Anchor component={Link} to={goalsLink(group, ENDS)} inherit>
            {name}
          </Anchor>
        )}
      </Table.Th>
      <Table.Td className={classes.number}>
        <CountLink counts={group} statuses={ENDS} />
      </Table.Td>
      <Table.Td className={classes.rate}>
        <div className={classes.rateCell}>
          {group.success_rate !== null && <RateBar rate={group.success_rate} />}
          <RateLink counts={group} />
        </div>
      </Table.Td>
      {ENDS_BUT_SUCCESS.map((status) => (
        <Table.Td key={status} className={classes.number} visibleFrom="sm">
          <CountLink counts={group} statuses={[status]} />
        </Table.Td>
      ))}
      <Table.Td className={classes.number}>
        <DurationLink counts={group} of="median" />
      </Table.Td>
      <Table.Td className={classes.number} visibleFrom="md">
        <DurationLink counts={group} of="p90" />
      </Table.Td>
      <Table.Td className={classes.number} visibleFrom="md">
        {tenths(group.mean_retries)}
      </Table.Td>
      <Table.Td visibleFrom="lg">
        {group.errors.slice(0, MAX_ERRORS).map((error) => (
          <div key={error.code}>
            <ErrorLink counts={group} error={error} /> {error.count}
          </div>
        ))}
      </Table.Td>
    </Table.Tr>
  );
});

/** The share of succeeded goals, and of those that failed. The number next to it says the same. */
function RateBar({ rate }: { rate: number }) {
  return (
    <div className={classes.bar} aria-hidden="true">
      <div className={classes.good} style={{ flexGrow: rate }} />
      <div className={classes.bad} style={{ flexGrow: 1 - rate }} />
    </div>
  );
}

/** Why goals did not succeed, the most frequent reason first. */
export function ErrorTable({ total }: { total: GoalCounts }) {
  const { errors, other_errors, ended } = total;
  if (errors.length === 0) {
    return (
      <Text size="sm" c="dimmed">
        No goal ended with an error.
      </Text>
    );
  }
  return (
    <Table verticalSpacing="xs" horizontalSpacing={8} className={classes.errors ?? ""}>
      <Table.Thead>
        <Table.Tr>
          <Table.Th>Error</Table.Th>
          <Table.Th visibleFrom="sm">Code</Table.Th>
          <Table.Th className={classes.number}>Goals</Table.Th>
          <Table.Th className={classes.number}>Of all</Table.Th>
        </Table.Tr>
      </Table.Thead>
      <Table.Tbody>
        {errors.map((error) => (
          <Table.Tr key={error.code}>
            <Table.Th scope="row" className={classes.key}>
              <ErrorLink counts={total} error={error} />
            </Table.Th>
            <Table.Td visibleFrom="sm">
              <Code className={classes.code ?? ""}>{error.code}</Code>
            </Table.Td>
            <Table.Td className={classes.number}>
              <NumberLink
                text={fixed(error.count, 0)}
                to={goalsLink(total, ENDS, error.code)}
                label={`goals with the error ${error.code}`}
              />
            </Table.Td>
            <Table.Td className={classes.number}>{percent(error.count / ended)}</Table.Td>
          </Table.Tr>
        ))}
        {other_errors > 0 && (
          <Table.Tr>
            <Table.Th scope="row" className={classes.key}>
              Other errors
            </Table.Th>
            <Table.Td visibleFrom="sm" />
            <Table.Td className={classes.number}>{fixed(other_errors, 0)}</Table.Td>
            <Table.Td className={classes.number}>{percent(other_errors / ended)}</Table.Td>
          </Table.Tr>
        )}
      </Table.Tbody>
    </Table>
  );
}

interface ErrorLinkProps {
  counts: GoalCounts;
  error: GoalCounts["errors"][number];
}

/** What an error code means; leads to the goals that have it. */
function ErrorLink({ counts, error: { code } }: ErrorLinkProps) {
  return (
    <Anchor component={Link} to={goalsLink(counts, ENDS, code)} inherit>
      {codeWords(code)}
    </Anchor>
  );
}
