import type { Alert } from "@dock-gateway/client";
import type { Naming } from "../fleet/names";
import type { Together } from "./order";

/** What is said of a stop of several robots. */
const STOPPED = "Goals are refused. Check that the area is clear, then release the stop.";

/** The robots that alerts are about, as lists show them. */
export function robotsOf(alerts: readonly Alert[], naming: Naming): string[] {
  return naming.inOrder(alerts.flatMap(({ robot }) => robot ?? []));
}

/** What to do about alerts that are shown as one. */
export function detailOf(alerts: Together): string {
  return alerts.length === 1 ? alerts[0].detail : STOPPED;
}
