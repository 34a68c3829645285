import { expect, it } from "vitest";
import { drainWords } from "../src/battery/drain";
import { noPoints } from "../src/store/batterySeries";

const HOUR = 3600;

/** A week of hours: down by so much an hour for 12 hours of each day, and charged in the rest. */
function week(before: number, now: number, hours = 7 * 24) {
  const points = noPoints();
  let charge = 100;
  for (let hour = 0; hour < hours; hour += 1) {
    const rate = hour < hours / 2 ? before : now;
    charge = hour % 24 < 12 ? charge - rate : Math.min(100, charge + rate);
    points.times.push(hour * HOUR);
    points.bands.percentage.mean.push(charge);
  }
  return points;
}

it("says how the battery's discharge has changed, where there is enough to tell", () => {
  const words = (points: ReturnType<typeof week>) => drainWords(points, () => "24 Nov");
  expect(words(week(4, 5))).toBe(
    "The battery drains 25 % faster than before (5.0 % an hour since 24 Nov, before 4.0 %).",
  );
  expect(words(week(4, 2))).toMatch(/^The battery drains 50 % slower/);
  expect(words(week(4, 4.4))).toBeNull();
  expect(words(week(4, 6, 40))).toBeNull();
  expect(words(week(0.1, 0.2))).toBeNull();
  expect(words(noPoints())).toBeNull();
});
