import { WEEKDAYS } from "../../../ui/timesOfDay";
import type { NamedSchedule } from "../schedules/schedules";

/** A time at which a schedule will queue a mission. */
export interface Plan {
  schedule: NamedSchedule;
  /** In ms. */
  at: number;
}

const MINUTE_MS = 60_000;
const DAY_MS = 86_400_000;

/** What schedules will queue from one time up to but not including another one (ms), by time. */
export function plansOf(schedules: readonly NamedSchedule[], from: number, to: number): Plan[] {
  return schedules
    .flatMap((schedule) => timesOf(schedule, from, to).map((at) => ({ schedule, at })))
    .sort((one, other) => one.at - other.at);
}

function timesOf({ enabled, next_at, every, daily }: NamedSchedule, from: number, to: number): number[] {
  if (!enabled || next_at === null) return [];
  const next = Date.parse(next_at);
  const first = Math.max(next, from);
  if (every !== null) {
    const step = every.minutes * MINUTE_MS;
    const start = next + Math.ceil((first - next) / step) * step;
    return start < to
      ? Array.from({ length: Math.ceil((to - start) / step) }, (_, n) => start + n * step)
      : [];
  }
  const times = daily === null ? [next] : dailyTimes(daily, first, to);
  return times.filter((at) => at >= first && at < to);
}

/** The times of day near a span of time, each moment once. */
function dailyTimes(daily: NonNullable<NamedSchedule["daily"]>, from: number, to: number): number[] {
  const clock = clockIn(daily.time_zone);
  if (clock === null) return [from];
  const moments = new Set<number>();
  // The day of a zone may be a day off from that in UTC.
  for (let day = from - DAY_MS; day <= to + DAY_MS; day += DAY_MS) {
    const date = new Date(day);
    const weekday = WEEKDAYS[(date.getUTCDay() + 6) % 7] as (typeof daily.weekdays)[number];
    if (!daily.weekdays.includes(weekday)) continue;
    for (const time of daily.times)
      moments.add(momentOf(`${date.toISOString().slice(0, 10)}T${time}`, clock));
  }
  return [...moments];
}

/** Tells the local time of a moment: `2026-11-30T06:00`. */
type Clock = (ms: number) => string;

/** Null where the browser does not know the zone. */
function clockIn(timeZone: string): Clock | null {
  try {
    const format = new Intl.DateTimeFormat("en-US", {
      timeZone,
      hourCycle: "h23",
      year: "numeric",
      month: "2-digit",
      day: "2-digit",
      hour: "2-digit",
      minute: "2-digit",
    });
    return (ms) => {
      const parts = format.formatToParts(ms);
      const read = (type: string) => parts.find((part) => part.type === type)?.value ?? "";
      return `${read("year")}-${read("month")}-${read("day")}T${read("hour")}:${read("minute")}`;
    };
  } catch {
    return null;
  }
}

/** The first moment at a local time; of one that is left out as clocks go forward, the first one after it. */
function momentOf(local: string, clock: Clock): number {
  const asUtc = Date.parse(`${local}Z`);
  const offsetAt = (ms: number) => Date.parse(`${clock(ms)}Z`) - ms;
  // Clocks change at most once within two days.
  const offsets = [offsetAt(asUtc - DAY_MS), offsetAt(asUtc + DAY_MS)];
  const moments = offsets.map((offset) => asUtc - offset).sort((one, other) => one - other);
  const found = moments.find((ms) => clock(ms) === local);
  if (found !== undefined) return found;
  let moment = moments[0] ?? asUtc;
  while (clock(moment) < local) moment += MINUTE_MS;
  return moment;
}
