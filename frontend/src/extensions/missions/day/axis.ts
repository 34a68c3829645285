import { dayOf, startOfDay } from "../../../ui/time";
import type { Period } from "./bars";

const HOUR_MS = 3_600_000;
const MINUTE_MS = 60_000;

/** How much of the day is seen. */
export type Span = "day" | "6h" | "1h";

export const SPANS: { value: Span; label: string }[] = [
  { value: "day", label: "Day" },
  { value: "6h", label: "6 hours" },
  { value: "1h", label: "1 hour" },
];

const LENGTHS = { "6h": 6 * HOUR_MS, "1h": HOUR_MS };

/** The day of a time, in the zone that is shown. */
export function dayAround(now: number): Period {
  const day = dayOf(now);
  return { from: startOfDay(day), to: startOfDay(day, 1) };
}

/**
 * What is seen of a day.
 *
 * @param middle What it shows in the middle (ms), as far as the day goes.
 */
export function axisOf(span: Span, day: Period, middle: number): Period {
  if (span === "day") return day;
  const length = LENGTHS[span];
  const latest = Math.max(day.from, day.to - length);
  // Steps of five minutes: the axis does not creep along with now.
  const start = Math.round((middle - length / 2) / (5 * MINUTE_MS)) * 5 * MINUTE_MS;
  const from = Math.min(Math.max(start, day.from), latest);
  return { from, to: from + length };
}

/** What an axis shows in the middle once it is moved by half its length. */
export function movedMiddle({ from, to }: Period, by: -1 | 1): number {
  return (from + to) / 2 + (by * (to - from)) / 2;
}

const STEPS = [5, 10, 15, 30, 60, 120, 180, 240, 360].map((minutes) => minutes * MINUTE_MS);

/** Round times on an axis with room between them. @param most How many there may be. */
export function ticksOf({ from, to }: Period, day: Period, most: number): number[] {
  const step = STEPS.find((each) => (to - from) / each <= most) ?? 6 * HOUR_MS;
  const first = day.from + Math.ceil((from - day.from) / step) * step;
  const ticks: number[] = [];
  for (let tick = first; tick <= to; tick += step) ticks.push(tick);
  return ticks;
}
