import { Anchor, Code, Table, Text } from "@mantine/core";
import { Link } from "react-router";
import type { GoalCounts } from "../api/types";
import { codeWords } from "../goal/words";
import { fixed } from "../ui/numbers";
import { NumberLink } from "./cells";
import classes from "./statistics.module.css";
import { ENDS, goalsLink, percent } from "./words";

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
export function ErrorLink({ counts, error: { code } }: ErrorLinkProps) {
  return (
    <Anchor component={Link} to={goalsLink(counts, ENDS, code)} inherit>
      {codeWords(code)}
    </Anchor>
  );
}
