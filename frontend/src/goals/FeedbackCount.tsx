import { rate } from "../docking/rate";
import { useAtTime } from "../store/clock";

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
