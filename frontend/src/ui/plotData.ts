import { alike, COMPARED, type Digits, decimalsOf, NO_DIGITS, withNumber } from "./numbers";
import type { BAND_COLORS } from "./plotLook";

/** What a plot draws, kept outside of React: it looks whether the version has changed before it draws anew. */
export interface PlotSource {
  readonly version: number;
  /** The x values, ascending, then those of each line; null is a gap. */
  read(): [number[], ...(number | null)[][]];
}

/** A span of the x axis that is coloured behind the lines, with its name. */
export interface PlotBand {
  from: number;
  /** Null up to the right edge. */
  to: number | null;
  label: string;
  color: keyof (typeof BAND_COLORS)["light"];
}

export interface PlotLine {
  label: string;
  unit: string | null;
  /** How its values are written. */
  digits: Digits;
  /** A value in words, where they are not its number and unit. */
  words?: (value: number) => string;
}

/** Room above and below the values, so that a steady one is no line on the edge. */
export function roomyRange(min: number | null, max: number | null): [number, number] {
  if (min === null || max === null) return [0, 1];
  const room = max > min ? (max - min) * 0.08 : Math.max(Math.abs(max) * 0.05, 0.5);
  return [min - room, max + room];
}

/** The numbers beside an axis, with as many decimals as the step from one to the next has. */
export function axisNumbers(splits: readonly number[], step: number): string[] {
  const { magnitude } = splits.reduce(withNumber, NO_DIGITS);
  return splits.map((split) => alike(split, { decimals: decimalsOf(step), magnitude }));
}

/** A value with its unit, as long as all values of its line. */
export function lineWords({ digits, unit, words }: PlotLine, value: number): string {
  if (words !== undefined) return words(value);
  const text = alike(value, digits, COMPARED);
  return unit === null ? text : `${text} ${unit}`;
}
