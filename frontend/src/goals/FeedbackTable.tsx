import { Table, Text } from "@mantine/core";
import { memo, useMemo } from "react";
import { constantName, type JsonSchema, type SchemaNode, unitOf } from "../api/jsonSchema";
import { NOT_MEASURED } from "../ui/messageWords";
import { alike, COMPARED, type Digits } from "../ui/numbers";
import { Time } from "../ui/Time";
import { formatElapsed } from "../ui/time";
import type { FeedbackRow } from "./feedbackLog";
import { type FoundField, nodeOf, numberAt, shortNames } from "./fields";
import classes from "./goalPage.module.css";
import { useWatched } from "./useGoalWatch";

/** More fields than these are in the message below. */
const COLUMNS = 10;

interface FeedbackTableProps {
  /** In the order that they are shown in. */
  rows: readonly FeedbackRow[];
  /** When the goal began (ms). */
  start: number;
  schema: JsonSchema | undefined;
  chosen: string | null;
  /** The row at the moment that is marked. */
  marked: string | null;
  onChoose: (id: string) => void;
  /** The pointer or the focus rests on the rows, or has left them. */
  onRest: (yes: boolean) => void;
}

/** Messages of a goal's feedback, a row each, with the numbers that were measured. */
export function FeedbackTable(props: FeedbackTableProps) {
  const { rows, start, schema, chosen, marked, onChoose, onRest } = props;
  const { crosshair } = useWatched();
  const columns = useColumns(schema);
  const leave = () => {
    crosshair.point(null);
    onRest(false);
  };
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
            <Table.Th data-number>Since the start</Table.Th>
            <Table.Th data-number>Time</Table.Th>
            {columns.map(({ field, name, unit, named }) => (
              <Table.Th key={field.name} title={field.name} data-number={!named || undefined}>
                {name}
                {unit !== null && ` (${unit})`}
              </Table.Th>
            ))}
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody
          onMouseEnter={() => onRest(true)}
          onMouseLeave={leave}
          onFocus={() => onRest(true)}
          onBlur={leave}
        >
          {rows.map((row) => (
            <Row
              key={row.id}
              row={row}
              start={start}
              columns={columns}
              chosen={row.id === chosen}
              marked={row.id === marked}
              onChoose={onChoose}
              onPoint={crosshair.point}
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
  marked: boolean;
  onChoose: (id: string) => void;
  /** The pointer or the focus is on it (s since the goal began). */
  onPoint: (moment: number) => void;
}

const Row = memo(function Row({ row, start, columns, chosen, marked, onChoose, onPoint }: RowProps) {
  const point = () => onPoint((row.time - start) / 1000);
  return (
    <Table.Tr
      data-chosen={chosen || undefined}
      data-marked={marked || undefined}
      onMouseEnter={point}
      onFocus={point}
    >
      <Table.Td data-number>
        <button
          type="button"
          className={classes.choose}
          aria-pressed={chosen}
          onClick={() => onChoose(row.id)}
        >
          {sinceStart(row, start)}
        </button>
      </Table.Td>
      <Table.Td data-number>
        <Time value={row.time} precise />
      </Table.Td>
      {columns.map((column) => (
        <Table.Td key={column.field.name} data-number={!column.named || undefined}>
          <Cell value={numberAt(row.message, column.field)} column={column} />
        </Table.Td>
      ))}
    </Table.Tr>
  );
});

function Cell({ value, column }: { value: number | null; column: Column }) {
  if (value === null) {
    return (
      <Text span size="sm" c="dimmed" fs="italic">
        {NOT_MEASURED}
      </Text>
    );
  }
  return constantName(column.node, value) ?? alike(value, column.digits, COMPARED);
}

interface Column {
  field: FoundField;
  name: string;
  node: SchemaNode | undefined;
  unit: string | null;
  /** Whether its values have names. */
  named: boolean;
  digits: Digits;
}

/** The same until there are more fields, or more digits. */
function useColumns(schema: JsonSchema | undefined): readonly Column[] {
  const { fields } = useWatched().watch.log;
  const { version } = fields;
  // biome-ignore lint/correctness/useExhaustiveDependencies: the version tells that the fields are others
  return useMemo(() => {
    const chosen = columnsOf(fields.all);
    const names = shortNames(chosen);
    return chosen.map((field, index) => {
      const node = nodeOf(schema, field);
      const named = node?.schema["x-constants"] !== undefined;
      return {
        field,
        name: names[index] ?? field.name,
        node,
        unit: unitOf(node),
        named,
        digits: field.digits,
      };
    });
  }, [fields, version, schema]);
}

/** Those of a message's own fields before those of the items of arrays. */
function columnsOf(fields: readonly FoundField[]): FoundField[] {
  const isItem = ({ path }: FoundField) => path.some((step) => typeof step === "number");
  return [...fields.filter((field) => !isItem(field)), ...fields.filter(isItem)].slice(0, COLUMNS);
}

/** When a message came, to the millisecond. */
export function sinceStart(row: FeedbackRow, start: number): string {
  return formatElapsed((row.time - start) / 1000, 3);
}
