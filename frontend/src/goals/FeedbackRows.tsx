import { Button, Group, Stack, Table, Text } from "@mantine/core";
import { memo, useMemo, useState } from "react";
import { constantName, type JsonSchema, type SchemaNode, unitOf } from "../ui/jsonSchema";
import { NOT_MEASURED } from "../ui/messageWords";
import { Time } from "../ui/Time";
import { formatElapsed } from "../ui/time";
import type { FeedbackRow } from "./feedbackLog";
import { type FoundField, nodeOf, numberAt, shortNames } from "./fields";
import { NamedMessage } from "./GoalMessages";
import classes from "./goalPage.module.css";
import { useWatched } from "./useGoalWatch";

/** Rows of the table at once; more fields than these are in the message beside it. */
const ROWS = 12;
const COLUMNS = 10;

interface FeedbackRowsProps {
  /** When the goal began (ms). */
  start: number;
  schema: JsonSchema | undefined;
}

/** The messages of a goal's feedback, the newest first and as they come; and one of them in full. */
export function FeedbackRows({ start, schema }: FeedbackRowsProps) {
  const { log } = useWatched().watch;
  /** The row at the top while it stays; null follows the newest. */
  const [held, setHeld] = useState<string | null>(null);
  const [chosen, setChosen] = useState<string | null>(null);
  const top = held === null ? log.rows.length - 1 : Math.min(log.indexOf(held), log.rows.length - 1);
  const rows = log.rows.slice(Math.max(0, top + 1 - ROWS), top + 1).reverse();
  const shown = log.rows.find(({ id }) => id === chosen) ?? log.rows.at(-1);
  const goTo = (index: number) =>
    setHeld(index >= log.rows.length - 1 ? null : (log.rows[index]?.id ?? null));
  return (
    <Stack gap="lg">
      <Stack gap="xs">
        <FeedbackTable rows={rows} start={start} schema={schema} chosen={chosen} onChoose={setChosen} />
        <Group gap="xs">
          <Button
            variant="default"
            size="compact-sm"
            aria-pressed={held !== null}
            onClick={() => setHeld(held === null ? (log.rows.at(-1)?.id ?? null) : null)}
          >
            {held === null ? "Pause" : "Follow"}
          </Button>
          <Button variant="default" size="compact-sm" disabled={top < ROWS} onClick={() => goTo(top - ROWS)}>
            Older
          </Button>
          <Button
            variant="default"
            size="compact-sm"
            disabled={held === null}
            onClick={() => goTo(top + ROWS)}
          >
            Newer
          </Button>
        </Group>
      </Stack>
      <Stack gap="xs">
        {shown !== undefined && (
          <NamedMessage
            title={chosen === shown.id ? `Message at ${sinceStart(shown, start)}` : "Latest message"}
            value={shown.message}
            schema={schema}
            absent={NOT_MEASURED}
          />
        )}
        {chosen !== null && (
          <Group>
            <Button variant="default" size="compact-sm" onClick={() => setChosen(null)}>
              Show the latest
            </Button>
          </Group>
        )}
      </Stack>
    </Stack>
  );
}

interface FeedbackTableProps extends FeedbackRowsProps {
  rows: readonly FeedbackRow[];
  chosen: string | null;
  onChoose: (id: string) => void;
}

function FeedbackTable({ rows, start, schema, chosen, onChoose }: FeedbackTableProps) {
  const columns = useColumns(schema);
  return (
    <Table.ScrollContainer minWidth={300} scrollAreaProps={{ tabIndex: 0 }}>
      <Table
        verticalSpacing={4}
        horizontalSpacing={8}
        className={classes.rows ?? ""}
        data-testid="feedback-table"
      >
        <Table.Thead>
          <Table.Tr>
            <Table.Th>Since the start</Table.Th>
            <Table.Th>Time</Table.Th>
            {columns.map(({ field, name }) => (
              <Table.Th key={field.name} title={field.name}>
                {name}
              </Table.Th>
            ))}
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {rows.map((row) => (
            <Row
              key={row.id}
              row={row}
              start={start}
              columns={columns}
              chosen={row.id === chosen}
              onChoose={onChoose}
            />
          ))}
        </Table.Tbody>
      </Table>
    </Table.ScrollContainer>
  );
}

interface RowProps {
  row: FeedbackRow;
  start: number;
  columns: readonly Column[];
  chosen: boolean;
  onChoose: (id: string) => void;
}

const Row = memo(function Row({ row, start, columns, chosen, onChoose }: RowProps) {
  return (
    <Table.Tr data-chosen={chosen || undefined}>
      <Table.Td>
        <button
          type="button"
          className={classes.choose}
          aria-pressed={chosen}
          onClick={() => onChoose(row.id)}
        >
          {sinceStart(row, start)}
        </button>
      </Table.Td>
      <Table.Td>
        <Time value={row.time} />
      </Table.Td>
      {columns.map(({ field, node }) => (
        <Table.Td key={field.name}>
          <Cell value={numberAt(row.message, field)} node={node} />
        </Table.Td>
      ))}
    </Table.Tr>
  );
});

function Cell({ value, node }: { value: number | null; node: SchemaNode | undefined }) {
  if (value === null) {
    return (
      <Text span size="sm" c="dimmed" fs="italic">
        {NOT_MEASURED}
      </Text>
    );
  }
  const unit = unitOf(node);
  return constantName(node, value) ?? (unit === null ? value : `${value} ${unit}`);
}

interface Column {
  field: FoundField;
  name: string;
  node: SchemaNode | undefined;
}

/** The same until there are more fields. */
function useColumns(schema: JsonSchema | undefined): readonly Column[] {
  const { fields } = useWatched().watch.log;
  const { size } = fields;
  // biome-ignore lint/correctness/useExhaustiveDependencies: the number of fields tells that there are others
  return useMemo(() => {
    const chosen = columnsOf(fields.all);
    const names = shortNames(chosen);
    return chosen.map((field, index) => ({
      field,
      name: names[index] ?? field.name,
      node: nodeOf(schema, field),
    }));
  }, [fields, size, schema]);
}

/** Those of a message's own fields before those of the items of arrays. */
function columnsOf(fields: readonly FoundField[]): FoundField[] {
  const isItem = ({ path }: FoundField) => path.some((step) => typeof step === "number");
  return [...fields.filter((field) => !isItem(field)), ...fields.filter(isItem)].slice(0, COLUMNS);
}

function sinceStart(row: FeedbackRow, start: number): string {
  return formatElapsed((row.time - start) / 1000);
}
