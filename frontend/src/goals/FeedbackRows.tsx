import { Button, Group, Stack, Switch, Text } from "@mantine/core";
import { useEffect, useMemo, useState } from "react";
import { useSearchParams } from "react-router";
import type { JsonSchema } from "../api/jsonSchema";
import { NOT_MEASURED } from "../ui/messageWords";
import { FeedbackTable, sinceStart } from "./FeedbackTable";
import { ChangedRows, indexOf, rowAt, rowIndexAt } from "./feedbackLog";
import { NamedMessage } from "./GoalMessages";
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
  /** The same while the pointer or the focus is on the table. */
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
