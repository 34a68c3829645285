import type { Delivery, Webhook } from "../api/webhooks";
import type { Naming } from "../fleet/names";
import { formatTime } from "../ui/time";

export const SEVERITY_OPTIONS = [
  { value: "all", label: "All alerts" },
  { value: "critical", label: "Critical alerts only" },
];

export function severityWords({ severities }: Pick<Webhook, "severities">): string {
  return severities.includes("warning") ? "All alerts" : "Critical alerts only";
}

export const EVENTS: Record<Delivery["type"], string> = {
  "alert.raised": "Began",
  "alert.cleared": "Ended",
  test: "Sent by hand",
};

/** `Stopped, Left forklift`, `History lost` */
export function alertWords({ event: { data } }: Pick<Delivery, "event">, naming: Naming): string {
  if (!("title" in data)) return "Test";
  return data.robot === null ? data.title : `${data.title}, ${naming.nameOf(data.robot)}`;
}

export const STATES: Record<Delivery["state"], { words: string; color: string }> = {
  delivered: { words: "Delivered", color: "gray" },
  pending: { words: "Pending", color: "orange" },
  failed: { words: "Failed", color: "red" },
};

/** `204`, `The answer was 503, third attempt. Next at 17:02:11` */
export function outcomeWords({ state, status_code, error, attempts, next_at }: Delivery): string {
  if (state === "delivered") return attempts > 1 ? `${status_code}, attempt ${attempts}` : `${status_code}`;
  const tried =
    error === null ? "" : `${error.charAt(0).toUpperCase()}${error.slice(1)}, attempt ${attempts}`;
  const next = next_at === null || attempts === 0 ? "" : `Next at ${formatTime(Date.parse(next_at))}`;
  return [tried, next].filter((words) => words !== "").join(". ");
}

/** What came of a test, in a sentence. */
export function testWords({ state, status_code, error }: Delivery): string {
  return state === "delivered" ? `The test was delivered: the answer was ${status_code}.` : `${error}`;
}
