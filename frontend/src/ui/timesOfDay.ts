import { zoneName } from "./zone";

const DAYS: Record<string, string> = {
  mon: "Mon",
  tue: "Tue",
  wed: "Wed",
  thu: "Thu",
  fri: "Fri",
  sat: "Sat",
  sun: "Sun",
};
export const WEEKDAYS = Object.keys(DAYS);

export function dayWords(day: string): string {
  return DAYS[day] ?? day;
}

/** Times of day on days of the week, as they are typed. */
export interface TimesOfDay {
  /** HH:MM */
  times: string[];
  weekdays: string[];
  timeZone: string;
}

export type TimesErrors = Partial<Record<keyof TimesOfDay, string>>;

/** The same, as the gateway takes it. */
interface TimesBody<Day extends string = string> {
  times: string[];
  weekdays: Day[];
  time_zone: string;
}

/** @param stored What is stored; by default every day at 22:00. */
export function timesOf(stored: TimesBody | null | undefined): TimesOfDay {
  return {
    times: stored?.times ?? ["22:00"],
    weekdays: stored?.weekdays ?? [...WEEKDAYS],
    timeZone: stored?.time_zone ?? zoneName(),
  };
}

const TIME = /^([01]?\d|2[0-3]):[0-5]\d$/;

/** What is wrong with each field. */
export function timesErrors({ times, weekdays }: TimesOfDay): TimesErrors {
  const errors: TimesErrors = {};
  if (times.length === 0) errors.times = "Add a time, such as 22:00.";
  else if (!times.every((time) => TIME.test(time))) errors.times = "Times are from 00:00 to 23:59.";
  if (weekdays.length === 0) errors.weekdays = "Choose a day.";
  return errors;
}

/** What is stored of what was typed. */
export function timesBody({ times, weekdays, timeZone }: TimesOfDay): TimesBody {
  return { times: times.map((time) => time.padStart(5, "0")), weekdays, time_zone: timeZone };
}
