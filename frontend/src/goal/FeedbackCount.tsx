import { useAtTime } from "../clock/clock";

interface FeedbackCountProps {
  count: number;
  /** When the latest came (ms), oldest first; null for a goal that has ended. */
  arrivals: readonly number[] | null;
}

/** How many feedback messages have come, and how fast they come: a text of its own, which changes with each. */
export function FeedbackCount({ count, arrivals }: FeedbackCountProps) {
  const perSecond = useAtTime((now) => (arrivals === null ? "" : (rate(arrivals, now)?.toFixed(1) ?? "")));
  return `${count} ${count === 1 ? "message" : "messages"}${perSecond === "" ? "" : `, ${perSecond} Hz`}`;
}

const WINDOW_MS = 3000;

/** Messages a second over the last three seconds, or null where that is too few to say. */
export function rate(arrivals: readonly number[], now: number): number | null {
  const recent = arrivals.filter((time) => now - time <= WINDOW_MS);
  const [first] = recent;
  const last = recent.at(-1);
  if (first === undefined || last === undefined || last <= first) return null;
  return ((recent.length - 1) * 1000) / (last - first);
}
