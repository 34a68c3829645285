import { isTerminal } from "../store/goals";
import type { PlotBand } from "../ui/plotData";
import { stageName } from "./stages";
import type { Entry } from "./timeline";

const COLORS: Record<string, PlotBand["color"]> = {
  NAV_TO_STAGING_POSE: "cyan",
  CONTROLLING: "blue",
  UNDOCKING: "blue",
  WAIT_FOR_CHARGE: "green",
  RETRY: "orange",
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
