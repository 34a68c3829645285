import { fixed } from "../../ui/numbers";
import { goalsWords } from "./plots";
import type { DockingTrend } from "./requests";

/**
 * How docking has changed: `Docking takes 40 % longer than last week (median 31 s, before 22 s, 14 and 18 goals).` Null
 * where the gateway says that there is not enough to tell.
 */
export function changeWords({ change, now, before }: DockingTrend): string | null {
  if (change === null || now.median_s === null || before.median_s === null) return null;
  const share = `${fixed(Math.abs(change) * 100, 0)} %`;
  const how = change > 0 ? `${share} longer` : `${share} less time`;
  const medians = `median ${seconds(now.median_s)}, before ${seconds(before.median_s)}`;
  return `Docking takes ${how} than last week (${medians}, ${fixed(now.succeeded, 0)} and ${goalsWords(before.succeeded)}).`;
}

/** The change, else what was measured. */
export function trendWords(trend: DockingTrend): string {
  const { now } = trend;
  const change = changeWords(trend);
  if (change !== null) return change;
  if (now.median_s === null) return "No docking has succeeded in the last 7 days.";
  return `Docking takes ${seconds(now.median_s)} (median of ${goalsWords(now.succeeded)} in the last 7 days).`;
}

/** `31 s`, `4.2 s` */
export function seconds(value: number): string {
  return `${fixed(value, value < 10 ? 1 : 0)} s`;
}

/** A point of a small plot. */
export interface Spot {
  x: number;
  y: number;
}

/** The days that have a median, in a box that begins at 0 s; in runs of days without a gap. */
export function sparkline(
  days: readonly (number | null)[],
  { width, height, room }: { width: number; height: number; room: number },
): Spot[][] {
  const top = Math.max(...days.map((median) => median ?? 0), Number.MIN_VALUE);
  const step = (width - 2 * room) / Math.max(1, days.length - 1);
  const runs: Spot[][] = [];
  let run: Spot[] | null = null;
  for (const [index, median] of days.entries()) {
    if (median === null) {
      run = null;
      continue;
    }
    const spot = { x: room + index * step, y: room + (1 - median / top) * (height - 2 * room) };
    if (run === null) {
      run = [spot];
      runs.push(run);
    } else run.push(spot);
  }
  return runs;
}
