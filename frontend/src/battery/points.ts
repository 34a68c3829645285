import type { BatteryHistory, ClientError } from "@dock-gateway/client";
import { useEffect, useState } from "react";
import { toClientError } from "../api/errors";
import { batteryHistory } from "../api/history";
import { useFleet } from "../fleet/context";
import {
  type Column,
  inUnit,
  noPoints,
  type Points,
  QUANTITIES,
  type Quantity,
} from "../store/batterySeries";
import { useLive, useServices } from "../store/context";
import { formatSpread, formatValue } from "./quantities";
import { edges, type View } from "./view";

/** The gateway's answer, in seconds and in the units that are plotted. */
export function fromHistory(history: BatteryHistory): Points {
  const points = noPoints();
  points.times = history.time.map((time) => Date.parse(time) / 1000);
  for (const quantity of QUANTITIES) {
    const { mean, min, max } = history[quantity];
    const convert = (column: Column) => column.map((value) => inUnit(quantity, value));
    points.bands[quantity] = { mean: convert(mean), min: convert(min), max: convert(max) };
  }
  return points;
}

/**
 * Both in one, and a row of nulls in every gap. Of the past only what was not heard live is taken: what lies within its
 * resolution of a live point is that point.
 *
 * @param resolutionS How far apart the points of the past are at least.
 */
export function join(past: Points, live: Points, resolutionS: number): Points {
  const rows = merged(past, live, resolutionS);
  const limit = Math.max(gapLimit(rows.map(({ time }) => time)), 2.5 * resolutionS);
  const joined = noPoints();
  let last = Number.POSITIVE_INFINITY;
  for (const { time, source, index } of rows) {
    if (time - last > limit) append(joined, (last + time) / 2, null, 0);
    append(joined, time, source, index);
    last = time;
  }
  return joined;
}

interface Row {
  time: number;
  source: Points;
  index: number;
}

function merged(past: Points, live: Points, resolutionS: number): Row[] {
  const rows: Row[] = [];
  let next = 0;
  const takeLive = (before: number) => {
    for (; next < live.times.length && (live.times[next] as number) < before; next += 1)
      rows.push({ time: live.times[next] as number, source: live, index: next });
  };
  past.times.forEach((time, index) => {
    takeLive(time - resolutionS);
    const following = live.times[next];
    if (following !== undefined && following <= time + resolutionS) return;
    const previous = rows.at(-1);
    if (previous?.source === live && previous.time >= time - resolutionS) return;
    rows.push({ time, source: past, index });
  });
  takeLive(Number.POSITIVE_INFINITY);
  return rows;
}

function append(points: Points, time: number, source: Points | null, index: number): void {
  points.times.push(time);
  for (const quantity of QUANTITIES) {
    const { mean, min, max } = points.bands[quantity];
    const from = source?.bands[quantity];
    mean.push(from?.mean[index] ?? null);
    min.push(from?.min[index] ?? null);
    max.push(from?.max[index] ?? null);
  }
}

/** Without knowing how often a battery tells its state, a pause longer than this is a gap (s). */
const GAP_S = 15;
const SHORTEST_GAP_S = 5;
const ENOUGH = 5;

/** A pause longer than this (s) is a gap in the line, not a line across: three times what is usual here. */
export function gapLimit(times: readonly number[]): number {
  const spacings = times.slice(1).map((time, index) => time - (times[index] as number));
  if (spacings.length < ENOUGH) return GAP_S;
  spacings.sort((a, b) => a - b);
  return Math.max(SHORTEST_GAP_S, 3 * (spacings[spacings.length >> 1] as number));
}

/**
 * A quantity in words: its value at a point, without one that of the last message.
 *
 * @param until The right edge of what is shown, s since 1970.
 */
export function describe(points: Points, quantity: Quantity, index: number | null, until: number): string {
  const { mean, min, max } = points.bands[quantity];
  const last = points.times.findLastIndex((time) => time <= until);
  const at = index ?? last;
  const value = mean[at] ?? null;
  if (value !== null) return `${formatValue(quantity, value)}${formatSpread(quantity, min[at], max[at])}`;
  if (index !== null || last < 0) return formatValue(quantity, null);
  const before = mean.slice(0, last).findLast((each) => each !== null);
  return before === undefined ? "not measured" : `no longer measured, last ${formatValue(quantity, before)}`;
}

const POINTS = 600;
/** A hand that turns the wheel asks once. */
const CALM_MS = 150;
/** The shortest and the longest time until a view that follows now is read again (s); later points are live. */
const RENEW_S = { least: 10, most: 240 };

interface Past {
  points: Points;
  /** How far apart its points are at least (s). */
  resolutionS: number;
  loading: boolean;
  error: ClientError | null;
}

/** What the gateway has kept of the part of time that is shown; read again when the gateway is back. */
export function usePast(view: View): Past {
  const { http } = useFleet();
  const { robot, store } = useServices();
  const live = useLive();
  const [past, setPast] = useState<Past>({ points: noPoints(), resolutionS: 0, loading: true, error: null });

  useEffect(() => {
    if (!live) return;
    const abort = new AbortController();
    let timer: ReturnType<typeof setTimeout>;
    const read = async () => {
      const { from, to } = edges(view, store.gatewayNow() / 1000);
      try {
        const span = { since: from * 1000, until: to * 1000 + 1, points: POINTS };
        const history = await batteryHistory(http, robot, span, abort.signal);
        if (abort.signal.aborted) return;
        setPast({
          points: fromHistory(history),
          resolutionS: history.resolution_s,
          loading: false,
          error: null,
        });
      } catch (error) {
        if (abort.signal.aborted) return;
        setPast((before) => ({ ...before, loading: false, error: toClientError(error) }));
      }
      if (view.endS === null) {
        const renewS = Math.min(RENEW_S.most, Math.max(RENEW_S.least, view.spanS / 100));
        timer = setTimeout(read, renewS * 1000);
      }
    };
    setPast((before) => ({ ...before, loading: true }));
    timer = setTimeout(read, CALM_MS);
    return () => {
      clearTimeout(timer);
      abort.abort();
    };
  }, [http, robot, store, live, view]);

  return past;
}
