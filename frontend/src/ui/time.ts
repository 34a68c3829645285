const clock = new Intl.DateTimeFormat(undefined, { hour: "2-digit", minute: "2-digit", second: "2-digit" });
const dayAndClock = new Intl.DateTimeFormat(undefined, {
  day: "numeric",
  month: "short",
  hour: "2-digit",
  minute: "2-digit",
  second: "2-digit",
});
const millisecond = {
  hour: "2-digit",
  minute: "2-digit",
  second: "2-digit",
  fractionalSecondDigits: 3,
} as const;
const preciseClock = new Intl.DateTimeFormat(undefined, millisecond);
const dayAndPreciseClock = new Intl.DateTimeFormat(undefined, {
  day: "numeric",
  month: "short",
  ...millisecond,
});
const exact = new Intl.DateTimeFormat(undefined, {
  dateStyle: "full",
  timeStyle: "long",
});

/** A time in the reader's zone: the clock alone for today, with the day for any other. */
export function formatTime(ms: number, now: number = Date.now()): string {
  return (isSameDay(ms, now) ? clock : dayAndClock).format(ms);
}

/** The same with milliseconds. */
export function formatPreciseTime(ms: number, now: number = Date.now()): string {
  return (isSameDay(ms, now) ? preciseClock : dayAndPreciseClock).format(ms);
}

function isSameDay(ms: number, now: number): boolean {
  return new Date(ms).toDateString() === new Date(now).toDateString();
}

/** A time to the millisecond with its day and zone. */
export function formatExact(ms: number): string {
  return `${exact.format(ms)} (${new Date(ms).toISOString()})`;
}

/** `0.4 s`, `12 s`, `3 min 05 s`, `2 h 07 min`. */
export function formatDuration(ms: number): string {
  const seconds = Math.max(0, ms) / 1000;
  if (seconds < 10) return `${seconds.toFixed(1)} s`;
  const whole = Math.floor(seconds);
  if (whole < 60) return `${whole} s`;
  const two = (value: number) => String(value).padStart(2, "0");
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${two(whole % 60)} s`;
  if (whole < 86_400) return `${Math.floor(whole / 3600)} h ${two(Math.floor((whole % 3600) / 60))} min`;
  return `${Math.floor(whole / 86_400)} d ${Math.floor((whole % 86_400) / 3600)} h`;
}

/** Since the beginning of something: `0.25 s`, `1:05.00`, `1:02:05`. */
export function formatElapsed(seconds: number, decimals: number): string {
  const text = Math.abs(seconds).toFixed(decimals);
  const sign = seconds < 0 && Number(text) > 0 ? "−" : "";
  const whole = Math.floor(Number(text));
  if (whole < 60) return `${sign}${text} s`;
  const two = (value: number) => String(value).padStart(2, "0");
  const [, fraction] = text.split(".");
  const rest = `${two(whole % 60)}${fraction === undefined ? "" : `.${fraction}`}`;
  const minutes = Math.floor(whole / 60);
  if (minutes < 60) return `${sign}${minutes}:${rest}`;
  return `${sign}${Math.floor(minutes / 60)}:${two(minutes % 60)}:${rest}`;
}

/** A time for an `<input type="datetime-local">`, in the reader's zone. */
export function toLocalInput(time: string | null): string {
  if (time === null) return "";
  const date = new Date(time);
  return new Date(date.getTime() - date.getTimezoneOffset() * 60_000).toISOString().slice(0, 16);
}

/** The time (RFC 3339) in such an input; null where it is empty or not whole yet. */
export function fromLocalInput(text: string): string | null {
  const ms = Date.parse(text);
  return Number.isNaN(ms) ? null : new Date(ms).toISOString();
}
