import type { Points } from "../store/batterySeries";
import { fixed } from "../ui/numbers";

/** A trend is only said of this much time (s). */
const LEAST_SPAN_S = 2 * 86_400;
/** Each half of the time needs as much discharge: for so long (s), and by so many percent of the charge. */
const LEAST_S = 6 * 3600;
const LEAST_DROP = 10;
/** A smaller change is not worth a word. */
const LEAST_CHANGE = 0.2;

/**
 * How the discharge has changed: `The battery drains 25 % faster than before (5.0 % an hour since 24 Nov, before 4.0 %).`
 * The later half of what is shown, compared with the earlier; null where there is not enough to tell.
 *
 * @param dayWords What a time (s since 1970) is called.
 */
export function drainWords(points: Points, dayWords: (timeS: number) => string): string | null {
  const { times } = points;
  const [first, last] = [times[0], times.at(-1)];
  if (first === undefined || last === undefined || last - first < LEAST_SPAN_S) return null;
  const middle = (first + last) / 2;
  const before = drainOf(points, first, middle);
  const now = drainOf(points, middle, last);
  if (before === null || now === null) return null;
  const change = now / before - 1;
  if (Math.abs(change) < LEAST_CHANGE) return null;
  const how = `${fixed(Math.abs(change) * 100, 0)} % ${change > 0 ? "faster" : "slower"}`;
  return `The battery drains ${how} than before (${fixed(now, 1)} % an hour since ${dayWords(middle)}, before ${fixed(before, 1)} %).`;
}

/** Percent of the charge an hour, while the charge went down; null for too little of it. */
function drainOf({ times, bands }: Points, from: number, to: number): number | null {
  const { mean } = bands.percentage;
  let [seconds, drop] = [0, 0];
  for (let index = 1; index < times.length; index += 1) {
    const [start, end] = [times[index - 1] as number, times[index] as number];
    const [high, low] = [mean[index - 1], mean[index]];
    if (start < from || end > to || high == null || low == null || low >= high) continue;
    seconds += end - start;
    drop += high - low;
  }
  return seconds < LEAST_S || drop < LEAST_DROP ? null : drop / (seconds / 3600);
}
