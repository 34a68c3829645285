import { Button, Group, Paper, Text, Title } from "@mantine/core";
import { memo, useId, useMemo, useState } from "react";
import type { Alert } from "../api/types";
import { useFleetTopic, useNaming } from "../fleet/context";
import { AlertItem } from "./AlertItem";
import classes from "./alerts.module.css";
import { alertsOf, openAlerts, urgentFirst } from "./order";

/** So many are shown before somebody asks for the others. */
const FIRST = 4;

interface AlertListProps {
  /** Nothing where there is none, rather than a line that says so. */
  quiet?: boolean;
  /** The group that it is narrowed to; null for all robots. */
  group?: string | null;
}

/** What needs somebody's eyes, the most urgent first. Those that were acknowledged are folded away. */
export const AlertList = memo(function AlertList({ quiet = false, group = null }: AlertListProps) {
  const alerts = useFleetTopic("alerts");
  const naming = useNaming();
  const sorted = useMemo(() => urgentFirst(alertsOf(alerts, group, naming)), [alerts, group, naming]);
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
          {summary(open, sorted.length - open, group)}
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
      {sorted.length < alerts.length && (
        <Text size="sm" mt="xs">
          {outsideWords(alerts.filter((alert) => !sorted.includes(alert)))}
        </Text>
      )}
    </Paper>
  );
});

function summary(open: number, acknowledged: number, group: string | null): string {
  if (open === 0 && acknowledged === 0) return `No active alerts${group === null ? "" : ` in ${group}`}.`;
  const parts = [open === 0 ? "none is new" : `${open} not acknowledged`];
  if (acknowledged > 0) parts.push(`${acknowledged} acknowledged`);
  return parts.join(", ");
}

/** What is said of the alerts that the group filter hides. */
function outsideWords(outside: readonly Alert[]): string {
  const critical = openAlerts(outside).filter(({ severity }) => severity === "critical").length;
  const hidden =
    outside.length === 1 ? "1 alert of another robot is" : `${outside.length} alerts of other robots are`;
  return `${hidden} hidden by the group filter${critical > 0 ? `, ${critical} critical` : ""}.`;
}
