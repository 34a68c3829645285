import { fixed } from "./numbers";
import { shownZone, type Zone } from "./zone";

const second = { hour: "2-digit", minute: "2-digit", second: "2-digit" } as const;
const millisecond = { ...second, fractionalSecondDigits: 3 } as const;
const day = { day: "numeric", month: "short" } as const;

const clock = formatter(second);
const dayAndClock = formatter({ ...day, ...second });
const preciseClock = formatter(millisecond);
const dayAndPreciseClock = formatter({ ...day, ...millisecond });
const exact = formatter({ dateStyle: "full", timeStyle: "long" });

/** Writes times (ms) in the zone that is shown, with 24 hours a day. */
export function formatter(options: Intl.DateTimeFormatOptions): (ms: number) => string {
  const formats: Partial<Record<Zone, Intl.DateTimeFormat>> = {};
  return (ms) => {
    const zone = shownZone();
    formats[zone] ??= new Intl.DateTimeFormat(undefined, {
      ...options,
      hourCycle: "h23",
      ...(zone === "utc" ? { timeZone: "UTC" } : {}),
    });
    return formats[zone].format(ms);
  };
}

/** The clock alone for today, with the day for any other. */
export function formatTime(ms: number, now: number = Date.now()): string {
  return isSameDay(ms, now) ? clock(ms) : dayAndClock(ms);
}

/** Writes a time as `formatTime` does, with milliseconds. */
export function formatPreciseTime(ms: number, now: number = Date.now()): string {
  return isSameDay(ms, now) ? preciseClock(ms) : dayAndPreciseClock(ms);
}

function isSameDay(ms: number, now: number): boolean {
  return dayOf(ms) === dayOf(now);
}

/** A time to the millisecond with its day and zone. */
export function formatExact(ms: number): string {
  return `${exact(ms)} (${new Date(ms).toISOString()})`;
}

/** `0.4 s`, `12 s`, `3 min 05 s`, `2 h 07 min`. */
export function formatDuration(ms: number): string {
  const seconds = Math.max(0, ms) / 1000;
  if (seconds < 10) return `${fixed(seconds, 1)} s`;
  const whole = Math.floor(seconds);
  if (whole < 60) return `${whole} s`;
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${two(whole % 60)} s`;
  if (whole < 86_400) return `${Math.floor(whole / 3600)} h ${two(Math.floor((whole % 3600) / 60))} min`;
  return `${Math.floor(whole / 86_400)} d ${Math.floor((whole % 86_400) / 3600)} h`;
}

/** Since the beginning of something: `0.25 s`, `1:05.00`, `1:02:05`. */
export function formatElapsed(seconds: number, decimals: number): string {
  const rounded = Number(Math.abs(seconds).toFixed(decimals));
  const sign = seconds < 0 && rounded > 0 ? "−" : "";
  const whole = Math.floor(rounded);
  if (whole < 60) return `${sign}${fixed(rounded, decimals)} s`;
  const fraction = fixed(rounded - whole, decimals).slice(1);
  const rest = `${two(whole % 60)}${fraction}`;
  const minutes = Math.floor(whole / 60);
  if (minutes < 60) return `${sign}${minutes}:${rest}`;
  return `${sign}${Math.floor(minutes / 60)}:${two(minutes % 60)}:${rest}`;
}

const DAY_MS = 86_400_000;

/** The day of a time in the zone that is shown, or one some days later: `2026-11-22`. */
export function dayOf(ms: number, later = 0): string {
  if (shownZone() === "utc") return new Date(ms + later * DAY_MS).toISOString().slice(0, 10);
  const date = new Date(ms);
  date.setDate(date.getDate() + later);
  return `${date.getFullYear()}-${two(date.getMonth() + 1)}-${two(date.getDate())}`;
}

/** When a day begins in the zone that is shown, or one some days later (ms). */
export function startOfDay(day: string, later = 0): number {
  if (shownZone() === "utc") return Date.parse(`${day}T00:00:00Z`) + later * DAY_MS;
  const date = new Date(`${day}T00:00:00`);
  date.setDate(date.getDate() + later);
  return date.getTime();
}

/** The clock of a time in the zone that is shown: `23:59`. */
export function clockOf(ms: number): string {
  const date = new Date(ms);
  if (shownZone() === "utc") return date.toISOString().slice(11, 16);
  return `${two(date.getHours())}:${two(date.getMinutes())}`;
}

/** The time (ms) of a day at a clock, up to `24:00`; null where that is none. */
export function timeAt(day: string, clock: string): number | null {
  if (!/^(?:19[7-9]|2[01]\d)\d-\d\d-\d\d$/.test(day)) return null;
  if (!/^(?:[01]?\d|2[0-3]):[0-5]\d$|^24:00$/.test(clock)) return null;
  if (clock === "24:00") return startOfDay(day, 1);
  const ms = Date.parse(`${day}T${clock.padStart(5, "0")}:00${shownZone() === "utc" ? "Z" : ""}`);
  return Number.isNaN(ms) ? null : ms;
}

function two(value: number): string {
  return String(value).padStart(2, "0");
}
