import { describe, expect, it } from "vitest";
import { alike, decimalsOf, fixed, NO_DIGITS, shortest, withNumber } from "../src/ui/numbers";
import { axisNumbers } from "../src/ui/plotData";
import { formatElapsed } from "../src/ui/time";

const together = (...values: number[]) => {
  const digits = values.reduce(withNumber, NO_DIGITS);
  return values.map((value) => alike(value, digits));
};

describe("numbers that are read together", () => {
  it("have the same number of decimals, and a minus sign as wide as a digit", () => {
    expect(together(9, 8.95, -0.5)).toEqual(["9.00", "8.95", "−0.50"]);
    expect(together(0, 1, 1, 2)).toEqual(["0", "1", "1", "2"]);
    expect(together(1234567, -1)).toEqual(["1234567", "−1"]);
  });

  it("have no more decimals than they need where they stand alone", () => {
    expect([1.5, 12, 0.12345, -2, -0.0001].map((value) => shortest(value, 3))).toEqual([
      "1.5",
      "12",
      "0.123",
      "−2",
      "0",
    ]);
  });

  it("have no negative zero", () => {
    expect(together(-0, 1.5)).toEqual(["0.0", "1.5"]);
    expect(alike(-0.001, { decimals: 2, magnitude: 0 })).toBe("0.00");
    expect(fixed(-0.001, 2)).toBe("0.00");
  });

  it("have nine digits that count at most: a double's last ones are noise", () => {
    expect(together(0.1 + 0.2, 12.5)).toEqual(["0.3000000", "12.5000000"]);
    expect(together(52.123456789123)).toEqual(["52.1234568"]);
  });

  it("are told with an exponent where all of them are tiny", () => {
    expect(together(-6.1e-17, 0)).toEqual(["−6.100e−17", "0.00000000"]);
    expect(together(6.1e-17, 1.5)).toEqual(["0.00000000", "1.50000000"]);
  });

  it("change nothing where they have the digits already", () => {
    const digits = withNumber(NO_DIGITS, 8.95);
    expect(withNumber(digits, 9.1)).toBe(digits);
    expect([8.95, 9, 1e-7, 2.5e-7, 1e21].map(decimalsOf)).toEqual([2, 0, 7, 8, 0]);
  });
});

it("the numbers beside an axis have the decimals of its step", () => {
  expect(axisNumbers([8.8, 8.9, 9], 0.1)).toEqual(["8.8", "8.9", "9.0"]);
  expect(axisNumbers([-10, 0, 10], 10)).toEqual(["−10", "0", "10"]);
  expect(axisNumbers([0.2, 0.30000000000000004], 0.1)).toEqual(["0.2", "0.3"]);
});

it("the time since a beginning has fixed decimals, on either side of a minute", () => {
  expect([0, 0.25, 59.9996, 65, 3725.5].map((seconds) => formatElapsed(seconds, 3))).toEqual([
    "0.000 s",
    "0.250 s",
    "1:00.000",
    "1:05.000",
    "1:02:05.500",
  ]);
  expect([-0.0001, -1.5, 90].map((seconds) => formatElapsed(seconds, 1))).toEqual([
    "0.0 s",
    "−1.5 s",
    "1:30.0",
  ]);
  expect(formatElapsed(90, 0)).toBe("1:30");
});
