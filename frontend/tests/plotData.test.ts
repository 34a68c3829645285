import { describe, expect, it } from "vitest";
import { isolated, POINTS, roomyRange } from "../src/ui/plotData";

describe("the range of an axis", () => {
  it("shows at least what it is told to, so that noise looks like noise", () => {
    const [low, high] = roomyRange(1.998, 2, [0, 0.1]);
    expect([low < 0, high > 2, high < 2.5]).toEqual([true, true, true]);
    const [least, most] = roomyRange(-0.002, 0.002, [-0.05, 0.05]);
    expect([least < -0.05, most > 0.05]).toEqual([true, true]);
    expect(roomyRange(1.998, 2)[0]).toBeGreaterThan(1.9);
  });
});

describe("a line with gaps", () => {
  it("has a dot for each value that no line leads to, so that each value is drawn", () => {
    for (let pattern = 0; pattern < 1 << 9; pattern += 1) {
      const values = Array.from({ length: 9 }, (_, index) => ((pattern >> index) & 1 ? index : null));
      const dots = new Set(isolated(values));
      for (const [index, value] of values.entries()) {
        const joined = values[index - 1] != null || values[index + 1] != null;
        expect(dots.has(index)).toBe(value !== null && !joined);
      }
    }
  });

  it("needs none where every value has one", () => {
    const plot = {
      data: [
        [1, 2],
        [3, null],
      ],
    } as unknown as uPlot;
    const filter = POINTS.filter as (plot: uPlot, series: number, shown: boolean) => number[] | null;
    expect([filter(plot, 1, false), filter(plot, 1, true), filter(plot, 2, false)]).toEqual([[0], null, []]);
  });
});
