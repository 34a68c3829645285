import type { AnyGoal } from "../api/types";
import { formatDuration } from "../ui/time";

/** When a goal was created, and when it ended. */
export type Lifetime = Pick<AnyGoal, "created_at" | "finished_at">;

/**
 * How long a goal took, as the exported `duration_s` says, or has been running for: then in whole seconds, so that what
 * is renewed at different times says the same.
 *
 * @param now In the gateway's time (ms).
 */
export function durationWords({ created_at, finished_at }: Lifetime, now: number): string {
  const start = Date.parse(created_at);
  return finished_at === null ? soFarWords(start, now) : formatDuration(Date.parse(finished_at) - start);
}

/** For how long a goal has been running, in whole seconds. */
export function soFarWords(start: number, now: number): string {
  const seconds = Math.max(0, Math.floor((now - start) / 1000));
  return seconds < 10 ? `${seconds} s` : formatDuration(seconds * 1000);
}
