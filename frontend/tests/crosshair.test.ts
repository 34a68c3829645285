import { expect, it, vi } from "vitest";
import { momentIn, momentText, playFrom, stepOf } from "../src/goals/Replay";
import { Crosshair, lastUpTo } from "../src/ui/crosshair";

it("a crosshair is where the pointer is, else where it is held", () => {
  const crosshair = new Crosshair();
  const told = vi.fn();
  const forget = crosshair.subscribe(told);
  crosshair.hold(2);
  crosshair.point(5);
  crosshair.point(5);
  expect([crosshair.moment, crosshair.held, told.mock.calls.length]).toEqual([5, 2, 2]);
  crosshair.point(null);
  expect(crosshair.moment).toBe(2);
  forget();
  crosshair.hold(null);
  expect([crosshair.moment, told.mock.calls.length]).toEqual([null, 3]);
});

it("the last of ascending numbers up to a moment is found", () => {
  const times = [0, 1, 1, 4];
  const found = [-1, 0, 1, 3.9, 9].map((moment) => lastUpTo(moment, 4, (index) => times[index] ?? 0));
  expect(found).toEqual([-1, 0, 2, 2, 3]);
});

it("the moment of a replay is in the address, within the goal", () => {
  expect([null, "", "x", "-3", "4.25", "99"].map((text) => momentIn(text, 10))).toEqual([
    null,
    null,
    null,
    0,
    4.25,
    10,
  ]);
  expect([1 / 3, 4].map(momentText)).toEqual(["0.333", "4"]);
  expect([null, 4, 10].map((moment) => playFrom(moment, 10))).toEqual([0, 4, 0]);
  expect([10, 3600].map(stepOf)).toEqual([0.1, 6]);
});
