import { byName, type Naming } from "../../../fleet/names";
import { hasEnded } from "../queue";
import type { Mission, MissionStep } from "../requests";
import type { NamedSchedule } from "../schedules/schedules";
import type { Plan } from "./planned";

/** A part of the time axis (ms). */
export interface Period {
  from: number;
  to: number;
}

/** A mission from its start to its end, or to now. */
export interface MissionBar extends Period {
  kind: "mission";
  mission: Mission;
}

/** What a schedule will queue: a mission, for as long as its last one has taken; or many, from the first to the last one. */
export interface PlannedBar extends Period {
  kind: "planned";
  schedule: NamedSchedule;
  /** How many missions. */
  times: number;
}

/** Bars that have no room beside each other. */
export interface Bundle extends Period {
  kind: "bundle";
  bars: (MissionBar | PlannedBar)[];
}

export type Bar = MissionBar | PlannedBar;

/** Tells a bar from the others of its row. */
export function keyOf(bar: Bar | Bundle): string {
  if (bar.kind === "mission") return bar.mission.mission_id;
  if (bar.kind === "planned") return `${bar.schedule.id} ${bar.from}`;
  return `from ${bar.bars[0] === undefined ? bar.from : keyOf(bar.bars[0])}`;
}

/** The bars of a robot, by their start; of a group those that no robot has begun. */
export interface Row {
  /** Null for a group. */
  robot: string | null;
  group: string | null;
  bars: Bar[];
  /** How many of its missions have not begun. */
  next: number;
}

/**
 * A row for each robot, by name, and for each group for which there is something.
 *
 * @param robots Those that are there.
 * @param now In the gateway's time (ms).
 */
export function rowsOf(
  robots: readonly string[],
  missions: readonly Mission[],
  plans: readonly Plan[],
  now: number,
  naming: Naming,
): Row[] {
  const queued = missions.filter((mission) => mission.started_at === null && !hasEnded(mission));
  const due = plans.map(({ schedule }) => schedule);
  const names = [...robots, ...[...missions, ...due].flatMap(({ robot }) => robot ?? [])];
  const groups = [...queued, ...due].flatMap(({ robot, group }) => (robot === null ? (group ?? []) : []));
  const takers = [
    ...naming.inOrder(names).map((robot) => ({ robot, group: null })),
    ...[...new Set(groups)].sort(byName).map((group) => ({ robot: null, group })),
  ];
  return takers.map((taker) => {
    const isIts = ({ robot, group }: Pick<Mission, "robot" | "group">) =>
      taker.robot === null ? robot === null && group === taker.group : robot === taker.robot;
    const begun = missions.filter(isIts).flatMap((mission) => barOf(mission, now) ?? []);
    const planned = plannedBars(
      plans.filter(({ schedule }) => isIts(schedule)),
      missions,
    );
    const bars = [...begun, ...planned].sort((one, other) => one.from - other.from);
    return { ...taker, bars, next: queued.filter(isIts).length };
  });
}

/** From so many times on, those of a schedule are one bar. */
const MANY = 12;

function plannedBars(plans: readonly Plan[], missions: readonly Mission[]): PlannedBar[] {
  const schedules = [...new Set(plans.map(({ schedule }) => schedule))];
  return schedules.flatMap((schedule): PlannedBar[] => {
    const times = plans.filter((plan) => plan.schedule === schedule).map(({ at }) => at);
    const usual = lastTook(schedule.id, missions);
    const bar = { kind: "planned", schedule } as const;
    const [first, last] = [times[0], times.at(-1)];
    if (times.length >= MANY && first !== undefined && last !== undefined)
      return [{ ...bar, from: first, to: last, times: times.length }];
    return times.map((at) => ({ ...bar, from: at, to: at + usual, times: 1 }));
  });
}

/** Null for a mission that has not begun. */
function barOf(mission: Mission, now: number): MissionBar | null {
  const { started_at, finished_at } = mission;
  if (started_at === null) return null;
  const from = Date.parse(started_at);
  return { kind: "mission", mission, from, to: Math.max(from, endOf(finished_at, now)) };
}

function endOf(finished_at: string | null, now: number): number {
  return finished_at === null ? now : Date.parse(finished_at);
}

/** How long the last mission of a schedule took (ms); 0 where that is not known. */
function lastTook(schedule: string, missions: readonly Mission[]): number {
  const took = missions
    .filter((mission) => mission.schedule === schedule && mission.status === "succeeded")
    .sort((one, other) => Date.parse(other.created_at) - Date.parse(one.created_at))
    .map(({ started_at, finished_at }) => Date.parse(finished_at ?? "") - Date.parse(started_at ?? ""));
  return took[0] ?? 0;
}

/**
 * The bars that are seen, in lanes below each other: each bar has at least this room, and does not overlap another one of
 * its lane. Those that no lane has room for are bundled, but never the mission that the robot is on.
 *
 * @param least The shortest bar (ms).
 */
export function lanesOf(bars: readonly Bar[], axis: Period, least: number, most: number): (Bar | Bundle)[][] {
  const seen = bars.filter((bar) => bar.to >= axis.from && bar.from < axis.to);
  const lanes = fill(seen, axis, least, most);
  const isBundled = (bar: Bar) =>
    lanes.flat().some((each) => each.kind === "bundle" && each.bars.includes(bar));
  const present = seen.filter((bar) => bar.kind === "mission" && !hasEnded(bar.mission));
  if (!present.some(isBundled)) return lanes;
  const others = seen.filter((bar) => !present.includes(bar));
  return [...fill(others, axis, least, most - 1), ...fill(present, axis, least, 1)];
}

function fill(bars: readonly Bar[], axis: Period, least: number, most: number): (Bar | Bundle)[][] {
  const lanes: (Bar | Bundle)[][] = [];
  for (const bar of bars) {
    const { from } = roomOf(bar, axis, least);
    const lane = lanes.find((each) => endOfLane(each, axis, least) <= from);
    if (lane !== undefined) lane.push(bar);
    else if (lanes.length < most) lanes.push([bar]);
    else bundle(lanes, bar, (each) => endOfLane(each, axis, least));
  }
  return lanes;
}

/** What a bar takes up: at the end of the axis, the shortest one begins before its time. */
function roomOf(bar: Period, axis: Period, least: number): Period {
  const from = Math.min(Math.max(bar.from, axis.from), axis.to - least);
  return { from, to: Math.max(bar.to, from + least) };
}

function endOfLane(lane: readonly Period[], axis: Period, least: number): number {
  const last = lane.at(-1);
  return last === undefined ? Number.NEGATIVE_INFINITY : roomOf(last, axis, least).to;
}

/** Bundles a bar with the last one of the lane that has room first. */
function bundle(lanes: (Bar | Bundle)[][], bar: Bar, end: (lane: readonly Period[]) => number): void {
  const [lane] = [...lanes].sort((one, other) => end(one) - end(other));
  const last = lane?.pop();
  if (lane === undefined || last === undefined) return;
  const bars = last.kind === "bundle" ? last.bars : [last];
  lane.push({ kind: "bundle", from: last.from, to: Math.max(last.to, bar.to), bars: [...bars, bar] });
}

/** Where a period is on the axis, in percent of its width; the part that is seen. */
export function placeOf(period: Period, axis: Period): { left: number; width: number } {
  const length = axis.to - axis.from;
  const start = Math.min(Math.max(period.from, axis.from), axis.to);
  const end = Math.min(Math.max(period.to, start), axis.to);
  return { left: ((start - axis.from) / length) * 100, width: ((end - start) / length) * 100 };
}

/** A step that has begun, with when. */
export interface StepPart extends Period {
  step: MissionStep;
}

/** The steps of a mission that have begun, without those that have others inside. @param now In the gateway's time (ms). */
export function partsOf({ steps, finished_at }: Mission, now: number): StepPart[] {
  return steps.flatMap((step) => {
    if (step.started_at === null || step.repeat !== null || step.first_that_works !== null) return [];
    const from = Date.parse(step.started_at);
    return [{ step, from, to: Math.max(from, endOf(step.finished_at ?? finished_at, now)) }];
  });
}
