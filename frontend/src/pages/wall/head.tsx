import type { Alert } from "@dock-gateway/client";
import { useMemo } from "react";
import { SeverityMark } from "../../alerts/marks";
import { alertsOf, openAlerts, urgentFirst } from "../../alerts/order";
import { useSession } from "../../api/session";
import { useAtTime } from "../../clock/clock";
import { useFleetTopic, useNaming } from "../../fleet/context";
import { heldStops, holdsAll } from "../../stop/held";
import { Time } from "../../ui/Time";
import { formatter } from "../../ui/time";
import { useZone } from "../../ui/zone";
import classes from "./wall.module.css";

const clock = formatter({
  hour: "2-digit",
  minute: "2-digit",
  second: "2-digit",
  timeZoneName: "short",
});
const date = formatter({ weekday: "short", day: "numeric", month: "short" });

/** The time with its zone, to the second. */
export function Clock() {
  useZone();
  const time = useAtTime(clock);
  const day = useAtTime(date);
  return (
    <div className={classes.clock}>
      <span className={classes.date}>{day}</span> {time}
    </div>
  );
}

/** Whether what is shown is live, and which robots are stopped; nothing where all is well. */
export function State() {
  const { phase, since } = useFleetTopic("connection");
  const loggedOut = useSession().principal === null;
  const stop = useFleetTopic("stop");
  const robots = useFleetTopic("robots");
  const naming = useNaming();
  const held = useMemo(() => heldStops(stop, robots), [stop, robots]);
  const all = useMemo(() => holdsAll(held, robots), [held, robots]);
  const names = held.flatMap(({ holds }) => holds);
  const by = new Set(held.flatMap((each) => each.by ?? []));
  return (
    <div role="status" className={classes.states}>
      {phase === "connecting" && <p className={classes.state}>Connecting to the gateway</p>}
      {(phase === "reconnecting" || phase === "gone") && (
        <p className={classes.state} data-bad={phase}>
          {loggedOut
            ? "The login has ended, leave to log in"
            : phase === "gone"
              ? "The gateway is gone"
              : "Reconnecting to the gateway"}
          : as of <Time value={since} />
        </p>
      )}
      {names.length > 0 && (
        <p className={classes.state} data-bad="stop">
          {all ? "All robots" : naming.list(names)} stopped
          {by.size > 0 && ` by ${[...by].join(", ")}`}
        </p>
      )}
    </div>
  );
}

/** The number of alerts that are shown; the others are counted. */
const MOST = 4;

interface WallAlertsProps {
  alerts: readonly Alert[];
  group: string | null;
}

/** The unacknowledged alerts; with a group, those of the group and of the gateway. */
export function WallAlerts({ alerts, group }: WallAlertsProps) {
  const naming = useNaming();
  const open = useMemo(() => {
    const ours = openAlerts(alertsOf(alerts, group, naming));
    // A stop is said above.
    return urgentFirst(ours).filter(({ kind }) => kind !== "stop_latched");
  }, [alerts, group, naming]);
  if (open.length === 0) return null;
  return (
    <ul className={classes.alerts} aria-label="Alerts">
      {open.slice(0, open.length > MOST ? MOST - 1 : MOST).map(({ id, severity, title, robot }) => (
        <li key={id} data-severity={severity}>
          <SeverityMark mark={severity} />
          {title}
          {robot !== null && `: ${naming.nameOf(robot)}`}
        </li>
      ))}
      {open.length > MOST && <li>and {open.length - MOST + 1} more alerts</li>}
    </ul>
  );
}
