import { Button, Group, Stack, Switch, Text } from "@mantine/core";
import { useMemo, useState } from "react";
import { useSearchParams } from "react-router";
import type { JsonSchema } from "../ui/jsonSchema";
import { NOT_MEASURED } from "../ui/messageWords";
import { ChangedRows } from "./changes";
import { FeedbackTable, sinceStart } from "./FeedbackTable";
import { indexOf } from "./feedbackLog";
import { NamedMessage } from "./GoalMessages";
import { useWatched } from "./useGoalWatch";

/** Rows of the table at once. */
const ROWS = 12;

/** The table's rows are narrowed by this parameter of the address. */
const CHANGED = "changed";

interface FeedbackRowsProps {
  /** When the goal began (ms). */
  start: number;
  schema: JsonSchema | undefined;
}

/** The messages of a goal's feedback, the newest first and as they come; and one of them in full. */
export function FeedbackRows({ start, schema }: FeedbackRowsProps) {
  const { log } = useWatched().watch;
  const [parameters, setParameters] = useSearchParams();
  /** The row at the top while it stays; null follows the newest. */
  const [held, setHeld] = useState<string | null>(null);
  const [chosen, setChosen] = useState<string | null>(null);
  const changes = useMemo(() => new ChangedRows(log), [log]);
  const onlyChanged = parameters.get(CHANGED) === "true";
  const all = onlyChanged ? changes.read() : log.rows;
  const top = held === null ? all.length - 1 : Math.min(indexOf(all, held), all.length - 1);
  const rows = all.slice(Math.max(0, top + 1 - ROWS), top + 1).reverse();
  const shown = log.rows.find(({ id }) => id === chosen) ?? log.rows.at(-1);
  const goTo = (index: number) => setHeld(index >= all.length - 1 ? null : (all[index]?.id ?? null));
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
        <FeedbackTable rows={rows} start={start} schema={schema} chosen={chosen} onChoose={setChosen} />
        <Group gap="xs">
          <Button
            variant="default"
            size="compact-sm"
            aria-pressed={held !== null}
            onClick={() => setHeld(held === null ? (all.at(-1)?.id ?? null) : null)}
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
