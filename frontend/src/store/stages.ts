import type { LiveGoal } from "@dock-gateway/client";

/** Stages of one goal that are remembered. */
const MAX_VISITS = 200;

/** A goal was in this stage. */
export interface StageVisit {
  stage: string;
  /** Since then, in the gateway's time (ms); null where that is not known, because the goal was met in it. */
  since: number | null;
}

/** The goal's id → the stages that it was in, in order, without those of its end. */
export type Stages = ReadonlyMap<string, readonly StageVisit[]>;

/** Stages of the end and of no goal are not stages of the way. */
const NOT_ON_THE_WAY = new Set(["IDLE", "SUCCEEDED", "CANCELED", "ABORTED", "REJECTED"]);

/** A goal is seen in its stage. */
export function withStage(
  stages: Stages,
  { goal_id, stage }: Pick<LiveGoal, "goal_id" | "stage">,
  since: number | null,
): Stages {
  const known = stages.get(goal_id) ?? [];
  const visits = visit(known, stage, since);
  return visits === known ? stages : new Map(stages).set(goal_id, visits);
}

function visit(
  visits: readonly StageVisit[],
  stage: string | null,
  since: number | null,
): readonly StageVisit[] {
  if (stage === null || NOT_ON_THE_WAY.has(stage) || visits.at(-1)?.stage === stage) return visits;
  return [...visits, { stage, since }].slice(-MAX_VISITS);
}

/** A goal that may have changed during an outage: when its last stage ended is unknown. */
export function withGap(stages: Stages, goalId: string): Stages {
  const known = stages.get(goalId);
  const last = known?.at(-1);
  if (known === undefined || last === undefined) return stages;
  return new Map(stages).set(goalId, [...known.slice(0, -1), { ...last, since: null }]);
}

/** The status events of a goal's history, oldest first; `complete` where they reach back to its beginning. */
export interface PastOfWay {
  events: readonly { time: string; stage: string | null }[];
  complete: boolean;
}

/** Takes up what a goal's history tells of its way, and keeps what was seen that is not in it yet. */
export function withPast(stages: Stages, goalId: string, { events, complete }: PastOfWay): Stages {
  let visits: readonly StageVisit[] = [];
  for (const [index, { time, stage }] of events.entries())
    visits = visit(visits, stage, index === 0 && !complete ? null : Date.parse(time));
  if (visits.length === 0) return stages;
  const last = visits.at(-1)?.since ?? Number.NEGATIVE_INFINITY;
  const told = new Set(visits.map(({ stage }) => stage));
  for (const { stage, since } of stages.get(goalId) ?? [])
    if (since === null ? !told.has(stage) : since > last) visits = visit(visits, stage, since);
  return new Map(stages).set(goalId, visits);
}
