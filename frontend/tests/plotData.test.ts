import { describe, expect, it } from "vitest";
import { isolated, POINTS } from "../src/ui/plotData";

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
