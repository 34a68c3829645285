import type { Alert } from "@dock-gateway/client";
import { isUnder, type Naming } from "../fleet/names";
import { areOneStop } from "../stop/held";

/** What needs eyes first: not acknowledged before acknowledged, critical before warning, new before old. */
export function urgentFirst(alerts: readonly Alert[]): Alert[] {
  return [...alerts].sort(
    (a, b) =>
      Number(a.acknowledged !== null) - Number(b.acknowledged !== null) ||
      Number(b.severity === "critical") - Number(a.severity === "critical") ||
      Date.parse(b.started_at) - Date.parse(a.started_at),
  );
}

/** The alerts that are not acknowledged. */
export function openAlerts(alerts: readonly Alert[]): Alert[] {
  return alerts.filter((alert) => alert.acknowledged === null);
}

/** One alert, or several that are shown as one. */
export type Together = readonly [Alert, ...Alert[]];

/**
 * Alerts that are shown as one: a stop of several robots is one alert, unless some of it was acknowledged by others.
 *
 * @param sorted In the order in which they are shown.
 */
export function together(sorted: readonly Alert[]): Together[] {
  const shown: [Alert, ...Alert[]][] = [];
  for (const alert of sorted) {
    const same = shown.find(([first]) => isOneStop(first, alert));
    if (same === undefined) shown.push([alert]);
    else same.push(alert);
  }
  return shown;
}

function isOneStop(one: Alert, other: Alert): boolean {
  return (
    one.kind === "stop_latched" &&
    other.kind === one.kind &&
    one.acknowledged?.by === other.acknowledged?.by &&
    areOneStop(one.started_at, other.started_at) &&
    withoutRobot(one) === withoutRobot(other)
  );
}

/** What it says, whichever robot it is about. */
function withoutRobot({ robot, detail }: Alert): string {
  return robot === null ? detail : detail.replace(robot, "");
}

/** The alerts of a group: of its robots, of stops that hold one of them, and of the gateway itself; null is all. */
export function alertsOf(alerts: readonly Alert[], group: string | null, naming: Naming): readonly Alert[] {
  if (group === null) return alerts;
  const members = naming.robotsIn(group);
  return alerts.filter(
    ({ robot, kind }) =>
      robot === null ||
      members.includes(robot) ||
      (kind === "stop_latched" && members.some((member) => isUnder(member, robot))),
  );
}

/** How urgent a robot's alerts are: the higher, the more. */
export type Attention = 0 | 1 | 2 | 3;

/** By robot: that of its most urgent alert. Robots without one are left out. */
export function attentionOf(alerts: readonly Alert[]): ReadonlyMap<string, Attention> {
  const attention = new Map<string, Attention>();
  for (const { robot, severity, acknowledged } of alerts) {
    if (robot === null) continue;
    const level: Attention = acknowledged !== null ? 1 : severity === "critical" ? 3 : 2;
    if (level > (attention.get(robot) ?? 0)) attention.set(robot, level);
  }
  return attention;
}
