import {
  type GoalError,
  type GoalEvent,
  type GoalStatus,
  isTerminal,
  type LiveGoal,
} from "@dock-gateway/client";
import type { PlotBand } from "../ui/plotData";
import { stageName } from "./stages";

export type StatusEvent = Extract<GoalEvent, { type: "status" }>;

/** Something that changed in the life of a goal. */
export interface Entry {
  key: string;
  /** In the gateway's time (ms); null where it is not known when that began. */
  time: number | null;
  change:
    | { kind: "status"; status: GoalStatus; error: GoalError | null }
    | { kind: "stage"; stage: string; retries: number }
    | { kind: "silence"; silent: boolean };
  /** Until the next change, or the end of it (ms); null for the last one of a goal that goes on, for an end, and where it is not known. */
  lasted: number | null;
}

/** Stages that say no more than the status next to them. */
const SAID_BY_STATUS = new Set(["IDLE", "SUCCEEDED", "CANCELED", "ABORTED", "REJECTED"]);

/** How far a goal has come. */
const STEPS: readonly GoalStatus[] = ["pending", "accepted", "executing", "canceling"];

/** Events are in the order of their stamps, which are of two clocks: one that arrives late is no step back. */
function laterOf(before: GoalStatus | null, now: GoalStatus): GoalStatus {
  return before !== null && STEPS.includes(now) && STEPS.indexOf(now) < STEPS.indexOf(before) ? before : now;
}

/**
 * What changed with a goal, and when, oldest first.
 *
 * @param events Its status events in the order of their ids; where they do not reach back to its beginning (they were
 *   kept no longer, or are on their way), what the goal itself tells stands in.
 * @param complete Whether they do: the first of them tells when the goal came to be as it says.
 */
export function timelineOf(goal: LiveGoal, events: readonly StatusEvent[], complete: boolean): Entry[] {
  const entries: Omit<Entry, "lasted">[] = [];
  let [status, stage, retries, silent] = [null as GoalStatus | null, null as string | null, 0, false];

  const tell = (state: StatusEvent | LiveGoal, time: number | null, key: string) => {
    const now = laterOf(status, state.status);
    const add = (change: Entry["change"]) => entries.push({ key: `${key} ${change.kind}`, time, change });
    if (state.stalled !== silent && !isTerminal(state.status))
      add({ kind: "silence", silent: state.stalled });
    if (now !== status) add({ kind: "status", status: now, error: state.error });
    const told = state.stage !== null && !SAID_BY_STATUS.has(state.stage) && !isTerminal(state.status);
    const count = Math.max(retries, state.retries ?? 0);
    const again = state.stage !== stage || (state.stage === "RETRY" && count > retries);
    if (told && again) add({ kind: "stage", stage: state.stage ?? "", retries: count });
    [status, stage, retries, silent] = [now, state.stage, count, state.stalled];
  };

  for (const [index, event] of events.entries())
    tell(event, index === 0 && !complete ? null : Date.parse(event.time), event.id);
  // When a goal that goes on came to be as it is, it does not tell: each feedback message is an update.
  tell(goal, goal.finished_at === null ? null : Date.parse(goal.finished_at), "now");
  return entries.map((entry, index) => ({ ...entry, lasted: lastedOf(entry, entries[index + 1]) }));
}

function lastedOf(
  { time, change }: Omit<Entry, "lasted">,
  next: Omit<Entry, "lasted"> | undefined,
): number | null {
  if (
    time === null ||
    next === undefined ||
    next.time === null ||
    (change.kind === "status" && isTerminal(change.status) && change.status !== "lost")
  ) {
    return null;
  }
  return Math.max(0, next.time - time);
}

const COLORS: Record<string, PlotBand["color"]> = {
  NAV_TO_STAGING_POSE: "cyan",
  CONTROLLING: "blue",
  UNDOCKING: "blue",
  WAIT_FOR_CHARGE: "green",
  RETRY: "orange",
  CORRECTING: "orange",
  RETURN_TO_STAGING: "orange",
  WAIT_FOR_BATTERY: "orange",
  WAIT_FOR_ODOMETRY: "orange",
  WAIT_FOR_CLEARANCE: "orange",
};

/**
 * The stages of a goal, and the times in which its server was silent, as bands of a plot. Of what began at an unknown time
 * there is none.
 *
 * @param start When the goal began (ms).
 */
export function bandsOf(entries: readonly Entry[], start: number): PlotBand[] {
  return entries.flatMap(({ time, change }, index) => {
    if (time === null || change.kind === "status" || (change.kind === "silence" && !change.silent)) return [];
    const next = entries.slice(index + 1).find((later) => later.change.kind === change.kind || isEnd(later));
    if (next?.time === null) return [];
    const span = {
      from: (time - start) / 1000,
      to: next === undefined ? null : (next.time - start) / 1000,
    };
    if (change.kind === "silence") return [{ ...span, label: "Stalled", color: "orange" as const }];
    return [{ ...span, label: stageName(change.stage), color: COLORS[change.stage] ?? "gray" }];
  });
}

function isEnd({ change }: Entry): boolean {
  return change.kind === "status" && isTerminal(change.status);
}

/** The entry that a goal was at; -1 before the first one. Those of unknown times were before. */
export function entryAt(entries: readonly Entry[], moment: number): number {
  return entries.findLastIndex(({ time }) => time === null || time <= moment);
}
