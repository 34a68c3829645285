import type { Alert } from "@dock-gateway/client";
import { Anchor, Button, Group, Paper, Stack, Text, TextInput } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { type FormEvent, Fragment, memo, useId, useMemo, useState } from "react";
import { Link } from "react-router";
import { MAX_NAME, ownName, setOwnName } from "../access/who";
import { createAlerts } from "../api/client";
import { formatPercentage } from "../battery/words";
import { useFleet, useFleetPart, useFleetTopic, useNaming, useWhyNot } from "../fleet/context";
import { goalPath, robotPath } from "../fleet/names";
import { believed } from "../store/batterySeries";
import { Dialog } from "../ui/Dialog";
import { CommandErrorAlert } from "../ui/errors";
import { ReasonButton } from "../ui/ReasonButton";
import { useCommand } from "../ui/requests";
import { Heading } from "../ui/Section";
import { Time } from "../ui/Time";
import classes from "./alerts.module.css";
import { SeverityMark } from "./marks";
import { alertsOf, openAlerts, type Together, together, urgentFirst } from "./order";
import { detailOf, robotsOf } from "./words";

/** The number of alerts that are shown at first. */
const FIRST = 4;

interface AlertListProps {
  /** Nothing where there is none, rather than a line that says so. */
  quiet?: boolean;
  /** The group that it is narrowed to; null for all robots. */
  group?: string | null;
}

/** The alerts, the most urgent first. Those that were acknowledged are folded away. */
export const AlertList = memo(function AlertList({ quiet = false, group = null }: AlertListProps) {
  const alerts = useFleetTopic("alerts");
  const naming = useNaming();
  const sorted = useMemo(() => urgentFirst(alertsOf(alerts, group, naming)), [alerts, group, naming]);
  const [all, setAll] = useState(false);
  const id = useId();
  const items = useMemo(() => together(sorted), [sorted]);
  const open = together(openAlerts(sorted)).length;
  const shown = all ? items : items.slice(0, Math.min(open, FIRST));
  const hidden = items.length - shown.length;
  if (quiet && sorted.length === 0) return null;

  return (
    <Paper component="section" withBorder radius="md" className={classes.list} aria-labelledby={id}>
      <Group justify="space-between" gap="xs">
        <Heading order={2} id={id} title="Alerts" help="dashboard#alerts" />
        <Text size="sm" c={open === 0 ? "dimmed" : undefined}>
          {summary(open, items.length - open, group)}
        </Text>
      </Group>
      {shown.length > 0 && (
        <ul className={classes.alerts}>
          {shown.map((alerts) => (
            <AlertItem key={alerts[0].id} alerts={alerts} />
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
          {outsideWords(together(alerts.filter((alert) => !sorted.includes(alert))))}
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
function outsideWords(outside: readonly Together[]): string {
  const critical = outside.filter(
    ([first]) => first.acknowledged === null && first.severity === "critical",
  ).length;
  const hidden =
    outside.length === 1 ? "1 alert of another robot is" : `${outside.length} alerts of other robots are`;
  return `${hidden} hidden by the group filter${critical > 0 ? `, ${critical} critical` : ""}.`;
}

/** The most robots of one alert that are named; the others are counted. */
const NAMES = 6;

/** One alert, or what is one for several robots: what it is, what to do, and who has seen it. */
function AlertItem({ alerts }: { alerts: Together }) {
  const naming = useNaming();
  const [alert] = alerts;
  const { robot, severity, title, started_at, goal_id, acknowledged } = alert;
  const robots = robotsOf(alerts, naming);
  const what =
    robots.length === 0 ? title : `${title}: ${robots.map((name) => naming.fullNameOf(name)).join(", ")}`;
  return (
    <li
      className={classes.alert}
      data-severity={severity}
      data-acknowledged={acknowledged !== null || undefined}
    >
      <SeverityMark mark={acknowledged === null ? severity : "acknowledged"} />
      <div className={classes.words}>
        <Text fw={600}>
          {title}
          {robots.length > 0 && ": "}
          {robots.slice(0, NAMES).map((name, index) => (
            <Fragment key={name}>
              {index > 0 && ", "}
              <Anchor component={Link} to={robotPath(name)} inherit underline="always">
                {naming.fullNameOf(name)}
              </Anchor>
            </Fragment>
          ))}
          {robots.length > NAMES && ` and ${robots.length - NAMES} more`}
        </Text>
        <Text size="sm">{detailOf(alerts)}</Text>
        <Text size="sm" c="dimmed">
          {severity === "critical" ? "Critical" : "Warning"}, since <Time value={started_at} />
          {alert.kind === "low_battery" && robot !== null && <BatteryNow robot={robot} />}
          {goal_id !== null && (
            <>
              {". "}
              <Anchor component={Link} to={goalPath(goal_id, robot)} underline="always">
                See the goal
              </Anchor>
            </>
          )}
        </Text>
      </div>
      {acknowledged === null ? (
        <AcknowledgeButton alerts={alerts} what={what} />
      ) : (
        <Acknowledged alerts={alerts} what={what} {...acknowledged} />
      )}
    </li>
  );
}

/** The charge of a robot as its row and its page say it. */
function BatteryNow({ robot }: { robot: string }) {
  return useFleetPart("robots", (robots) => {
    const battery = robots.get(robot)?.battery;
    const percentage = battery === undefined ? null : (believed(battery)?.percentage ?? null);
    if (percentage === null) return "";
    return battery?.stale
      ? `, ${formatPercentage(percentage)} when last heard`
      : `, ${formatPercentage(percentage)} now`;
  });
}

interface AnswerProps {
  alerts: readonly Alert[];
  what: string;
}

function Acknowledged({
  alerts,
  what,
  by,
  acknowledged_at,
}: AnswerProps & { by: string; acknowledged_at: string }) {
  const { http, store } = useFleet();
  const withdraw = useCommand(async () => {
    await Promise.all(alerts.map(({ id }) => createAlerts(http).withdraw(id)));
    for (const alert of alerts) store.setAlert({ ...alert, acknowledged: null });
  });
  const reason = useWhyNotAnswer(withdraw.isPending);
  return (
    <>
      <Group gap="xs" className={classes.answer}>
        <Text size="sm" role="status">
          Acknowledged by <strong>{by}</strong> at <Time value={acknowledged_at} />
        </Text>
        <ReasonButton
          variant="subtle"
          size="compact-sm"
          reason={reason}
          aria-label={`Withdraw: ${what}`}
          onClick={() => withdraw.mutate()}
        >
          Withdraw
        </ReasonButton>
      </Group>
      {withdraw.error !== null && (
        <div className={classes.failed}>
          <CommandErrorAlert command="Withdraw" error={withdraw.error} onClose={withdraw.reset} />
        </div>
      )}
    </>
  );
}

/** Acknowledges an alert with the name that was given on this computer; asks for one where there is none. */
function AcknowledgeButton({ alerts, what }: AnswerProps) {
  const { http, store } = useFleet();
  const [asking, ask] = useDisclosure(false);
  const acknowledge = useCommand(async (by: string) => {
    const api = createAlerts(http);
    for (const answer of await Promise.all(alerts.map(({ id }) => api.acknowledge(id, by))))
      store.setAlert(answer);
  });
  const reason = useWhyNotAnswer(acknowledge.isPending);
  const press = () => {
    const name = ownName().trim();
    if (name === "") ask.open();
    else acknowledge.mutate(name);
  };
  return (
    <>
      <ReasonButton
        variant="default"
        size="compact-sm"
        className={classes.answer ?? ""}
        reason={reason}
        {...(reason === null ? { title: "Shows everyone that you have seen it" } : {})}
        aria-label={`Acknowledge: ${what}`}
        onClick={press}
      >
        Acknowledge
      </ReasonButton>
      {acknowledge.error !== null && (
        <div className={classes.failed}>
          <CommandErrorAlert command="Acknowledge" error={acknowledge.error} onClose={acknowledge.reset} />
        </div>
      )}
      <Dialog opened={asking} onClose={ask.close} title="Acknowledge as">
        <NameForm
          onName={(name) => {
            setOwnName(name);
            ask.close();
            acknowledge.mutate(name);
          }}
        />
      </Dialog>
    </>
  );
}

/** Why an alert can neither be acknowledged nor the acknowledgement be withdrawn now; null where it can. */
function useWhyNotAnswer(sending: boolean): string | null {
  const reason = useWhyNot("PUT /alerts/{alert_id}/acknowledgement");
  return reason ?? (sending ? "The gateway has not answered yet." : null);
}

function NameForm({ onName }: { onName: (name: string) => void }) {
  const [name, setName] = useState("");
  const given = name.trim();
  const submit = (event: FormEvent) => {
    event.preventDefault();
    if (given !== "") onName(given);
  };
  return (
    <form onSubmit={submit}>
      <Stack gap="md">
        <Text size="sm">
          Everyone with this dashboard open sees that you look after the alert. It stays in the list until it
          ends.
        </Text>
        <TextInput
          label="Your name"
          description="It is kept in this browser, for the next time and for Stop."
          autoComplete="name"
          maxLength={MAX_NAME}
          value={name}
          onChange={(event) => setName(event.currentTarget.value)}
          data-autofocus
        />
        <Group justify="flex-end">
          <Button
            type="submit"
            disabled={given === ""}
            title={given === "" ? "Type your name first." : undefined}
          >
            Acknowledge
          </Button>
        </Group>
      </Stack>
    </form>
  );
}
