import { type GoalCourse, isTerminal } from "../store/goals";
import type { StageVisit } from "../store/stages";

/** A stage of a goal's way and how long it took, or has taken so far (ms); null where its begin is not known. */
export interface StageSpan {
  stage: string;
  ms: number | null;
}

/** @param now In the gateway's time (ms). */
export function spansOf(goal: GoalCourse, visits: readonly StageVisit[], now: number): StageSpan[] {
  const end = isTerminal(goal.status) ? Date.parse(goal.finished_at ?? goal.updated_at) : now;
  return visits.map(({ stage, since }, index) => {
    const next = visits[index + 1];
    const until = next === undefined ? end : next.since;
    return { stage, ms: since === null || until === null ? null : Math.max(0, until - since) };
  });
}

/** How long a goal was in a stage, in all of its tries; null where that is not known. */
export function timeIn(stage: string, spans: readonly StageSpan[]): number | null {
  const times = spans.filter((span) => span.stage === stage).map(({ ms }) => ms);
  if (times.length === 0) return null;
  return times.reduce((sum, ms) => (sum === null || ms === null ? null : sum + ms), 0);
}
