import { Button, Group, Stack, Switch, Table, Text } from "@mantine/core";
import { memo, useEffect, useMemo, useState } from "react";
import { useSearchParams } from "react-router";
import { constantName, type JsonSchema, type SchemaNode, unitOf } from "../api/jsonSchema";
import { NOT_MEASURED } from "../ui/messageWords";
import { alike, COMPARED, type Digits } from "../ui/numbers";
import { Time } from "../ui/Time";
import { formatElapsed } from "../ui/time";
import { ChangedRows, type FeedbackRow, indexOf, rowAt, rowIndexAt } from "./feedbackLog";
import { type FoundField, nodeOf, numberAt, shortNames } from "./fields";
import { NamedMessage } from "./GoalMessages";
import classes from "./goalPage.module.css";
import { useHeldMoment, useMoment, useWatched } from "./useGoalWatch";

/** Rows of the table at once. */
const ROWS = 12;

/** The table's rows are narrowed by this parameter of the address. */
const CHANGED = "changed";

interface FeedbackRowsProps {
  /** When the goal began (ms). */
  start: number;
  schema: JsonSchema | undefined;
  /** Whether more of them may come. */
  growing: boolean;
  /** The id of the message that is shown in full; null for the latest. */
  chosen: string | null;
  onChoose: (id: string | null) => void;
}

/** The messages of a goal's feedback, the newest first and as they come; and one of them in full. */
export function FeedbackRows({ start, schema, growing, chosen, onChoose }: FeedbackRowsProps) {
  const { log } = useWatched().watch;
  const [parameters, setParameters] = useSearchParams();
  /** The row at the top while it stays; null follows the newest. */
  const [held, setHeld] = useState<string | null>(null);
  /** The row at the top while the pointer or the focus is on the table; null elsewhere. */
  const [still, setStill] = useState<string | null>(null);
  const moment = useMoment();
  const heldMoment = useHeldMoment();
  const changes = useMemo(() => new ChangedRows(log), [log]);
  const onlyChanged = parameters.get(CHANGED) === "true";
  const all = onlyChanged ? changes.read() : log.rows;
  const last = all.length - 1;
  const resting = still ?? held;
  const base = resting === null ? last : Math.min(indexOf(all, resting), last);
  const marked = moment === null ? -1 : rowIndexAt(all, start + moment * 1000);
  const away = (index: number) => index >= 0 && (index > base || index <= base - ROWS);
  const around = (index: number) => Math.min(last, Math.max(ROWS - 1, index + ROWS / 2));
  // Where the pointer is on a plot, the table shows what it points at.
  const top = moment !== heldMoment && still === null && away(marked) ? around(marked) : base;
  const rows = all.slice(Math.max(0, top + 1 - ROWS), top + 1).reverse();
  const atHeld = heldMoment === null ? undefined : rowAt(log.rows, start + heldMoment * 1000);
  const picked = chosen === null ? atHeld : log.rows[indexOf(log.rows, chosen)];
  const shown = picked ?? log.rows.at(-1);
  // biome-ignore lint/correctness/useExhaustiveDependencies: it goes to what was picked once, and may be turned over then
  useEffect(() => {
    if (picked === undefined) return;
    const index = rowIndexAt(all, picked.time);
    if (away(index)) goTo(around(index));
  }, [picked?.id, onlyChanged]);
  const goTo = (index: number) => setHeld(index >= last ? null : (all[index]?.id ?? null));
  const narrow = (yes: boolean) => {
    if (yes) parameters.set(CHANGED, "true");
    else parameters.delete(CHANGED);
    setParameters(parameters, { replace: true });
  };
  return (
    <Stack gap="lg">
      <Stack gap="xs">
        <Group justify="space-between" gap="xs">
          <Switch
            label="Only rows that changed"
            checked={onlyChanged}
            onChange={(event) => narrow(event.currentTarget.checked)}
          />
          {onlyChanged && (
            <Text size="sm" c="dimmed" className="tabular" data-testid="changed-count">
              {all.length} of {log.rows.length}
            </Text>
          )}
        </Group>
        <FeedbackTable
          rows={rows}
          start={start}
          schema={schema}
          chosen={chosen}
          marked={all[marked]?.id ?? null}
          onChoose={onChoose}
          onRest={(yes) => setStill(yes ? (rows[0]?.id ?? null) : null)}
        />
        <Group gap="xs">
          {growing && (
            <Button
              variant="default"
              size="compact-sm"
              aria-pressed={held !== null}
              onClick={() => setHeld(held === null ? (all.at(-1)?.id ?? null) : null)}
            >
              {held === null ? "Pause" : "Follow"}
            </Button>
          )}
          <Button
            variant="default"
            size="compact-sm"
            disabled={base < ROWS}
            onClick={() => goTo(base - ROWS)}
          >
            Older
          </Button>
          <Button
            variant="default"
            size="compact-sm"
            disabled={held === null}
            onClick={() => goTo(base + ROWS)}
          >
            Newer
          </Button>
        </Group>
      </Stack>
      <Stack gap="xs">
        {shown !== undefined && (
          <NamedMessage
            title={picked !== undefined ? `Message at ${sinceStart(shown, start)}` : "Latest message"}
            value={shown.message}
            schema={schema}
            absent={NOT_MEASURED}
          />
        )}
        {chosen !== null && (
          <Group>
            <Button variant="default" size="compact-sm" onClick={() => onChoose(null)}>
              Show the latest
            </Button>
          </Group>
        )}
      </Stack>
    </Stack>
  );
}

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
function FeedbackTable(props: FeedbackTableProps) {
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

/** The columns, which change only with more fields or more digits. */
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

/** The columns of a message's own fields, then those of the items of its arrays. */
function columnsOf(fields: readonly FoundField[]): FoundField[] {
  const isItem = ({ path }: FoundField) => path.some((step) => typeof step === "number");
  return [...fields.filter((field) => !isItem(field)), ...fields.filter(isItem)].slice(0, COLUMNS);
}

/** When a message came, to the millisecond. */
function sinceStart(row: FeedbackRow, start: number): string {
  return formatElapsed((row.time - start) / 1000, 3);
}
