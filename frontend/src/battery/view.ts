import { shortest } from "../ui/numbers";
import { formatTime, formatter } from "../ui/time";

/** The part of time that the plots show. */
export interface View {
  spanS: number;
  /** The right edge, s since 1970; null follows now. */
  endS: number | null;
}

const LIVE_SPAN_S = 300;
export const LIVE: View = { spanS: LIVE_SPAN_S, endS: null };

const MIN_SPAN_S = 2;
const MAX_SPAN_S = 31 * 86_400;
/** An anchor this near to the right edge of what follows now is that edge. */
const AT_THE_EDGE = 0.97;

export function edges({ spanS, endS }: View, now: number): { from: number; to: number } {
  const to = endS ?? now;
  return { from: to - spanS, to };
}

/** What was chosen with the mouse. */
export function between(from: number, to: number, now: number): View {
  const spanS = clamp(Math.abs(to - from));
  return settled(spanS, (from + to) / 2 + spanS / 2, now, false);
}

/**
 * Closer (factor over 1) or farther, with the moment at `anchor` (0 left, 1 right) staying where it is. What follows now
 * and gets farther goes on to follow it.
 */
export function zoom(view: View, factor: number, anchor: number, now: number): View {
  const { from } = edges(view, now);
  const spanS = clamp(view.spanS / factor);
  if (view.endS === null && (factor < 1 || anchor > AT_THE_EDGE)) return { spanS, endS: null };
  const moment = from + anchor * view.spanS;
  return settled(spanS, moment + (1 - anchor) * spanS, now, factor < 1);
}

/** Earlier (negative) or later, by a share of what is shown. */
export function pan(view: View, share: number, now: number): View {
  const { to } = edges(view, now);
  return settled(view.spanS, to + share * view.spanS, now, share > 0);
}

export function pause(view: View, now: number): View {
  return { ...view, endS: view.endS ?? now };
}

/** @param follow Whether an end that reaches now follows it from there on. */
function settled(spanS: number, end: number, now: number, follow: boolean): View {
  if (end < now) return { spanS, endS: end };
  return { spanS, endS: follow ? null : now };
}

function clamp(spanS: number): number {
  return Math.min(MAX_SPAN_S, Math.max(MIN_SPAN_S, spanS));
}

const bySecond = formatter({ hour: "2-digit", minute: "2-digit", second: "2-digit" });
const byMinute = formatter({ hour: "2-digit", minute: "2-digit" });
const byDay = formatter({ day: "numeric", month: "short" });

/** What stands below a mark of the time axis, the marks being `stepS` apart. */
export function formatMark(timeS: number, stepS: number): string {
  const format = stepS < 60 ? bySecond : stepS < 86_400 ? byMinute : byDay;
  return format(timeS * 1000);
}

/** A moment of a view, with its day where that is not today's. */
export function formatMoment(timeS: number, nowS: number): string {
  return formatTime(timeS * 1000, nowS * 1000);
}

/** `5 min`, `1 h`, `24 h`, `7 d` */
export function formatSpan(spanS: number): string {
  if (spanS < 120) return `${twoDigits(spanS)} s`;
  if (spanS < 7200) return `${Math.round(spanS / 60)} min`.replace(/^60 min$/, "1 h");
  if (spanS <= 172_800) return `${twoDigits(spanS / 3600)} h`;
  return `${twoDigits(spanS / 86_400)} d`;
}

function twoDigits(value: number): string {
  return shortest(Number(value.toPrecision(2)), 20);
}
