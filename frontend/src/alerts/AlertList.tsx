import { Button, Group, Paper, Text, Title } from "@mantine/core";
import { memo, useId, useMemo, useState } from "react";
import { useFleetTopic } from "../fleet/context";
import { AlertItem } from "./AlertItem";
import classes from "./alerts.module.css";
import { openAlerts, urgentFirst } from "./order";

/** So many are shown before somebody asks for the others. */
const FIRST = 4;

/**
 * What needs somebody's eyes, the most urgent first. Those that were acknowledged are folded away.
 *
 * @param quiet Nothing where there is none, rather than a line that says so.
 */
export const AlertList = memo(function AlertList({ quiet = false }: { quiet?: boolean }) {
  const alerts = useFleetTopic("alerts");
  const sorted = useMemo(() => urgentFirst(alerts), [alerts]);
  const [all, setAll] = useState(false);
  const id = useId();
  const open = openAlerts(sorted).length;
  const shown = all ? sorted : sorted.slice(0, Math.min(open, FIRST));
  const hidden = sorted.length - shown.length;
  if (quiet && sorted.length === 0) return null;

  return (
    <Paper component="section" withBorder radius="md" className={classes.list} aria-labelledby={id}>
      <Group justify="space-between" gap="xs">
        <Title order={2} size="h4" id={id}>
          Alerts
        </Title>
        <Text size="sm" c={open === 0 ? "dimmed" : undefined}>
          {summary(open, sorted.length - open)}
        </Text>
      </Group>
      {shown.length > 0 && (
        <ul className={classes.alerts}>
          {shown.map((alert) => (
            <AlertItem key={alert.id} alert={alert} />
          ))}
        </ul>
      )}
      {(hidden > 0 || all) && sorted.length > 0 && (
        <Button variant="subtle" size="compact-sm" mt={4} aria-expanded={all} onClick={() => setAll(!all)}>
          {all ? "Show the most urgent only" : `Show ${hidden} more`}
        </Button>
      )}
    </Paper>
  );
});

function summary(open: number, acknowledged: number): string {
  if (open === 0 && acknowledged === 0) return "No active alerts.";
  const parts = [open === 0 ? "none is new" : `${open} not acknowledged`];
  if (acknowledged > 0) parts.push(`${acknowledged} acknowledged`);
  return parts.join(", ");
}
