/** What a plot draws, kept outside of React: it looks whether the version has changed before it draws anew. */
export interface PlotSource {
  readonly version: number;
  /** The x values, ascending, then those of each line; null is a gap. */
  read(): [number[], ...(number | null)[][]];
}

export interface PlotLine {
  label: string;
  unit: string | null;
  /** A value in words, where they are not its number and unit. */
  words?: (value: number) => string;
}

/** Room above and below the values, so that a steady one is no line on the edge. */
export function roomyRange(min: number | null, max: number | null): [number, number] {
  if (min === null || max === null) return [0, 1];
  const room = max > min ? (max - min) * 0.08 : Math.max(Math.abs(max) * 0.05, 0.5);
  return [min - room, max + room];
}

/** A number as short as it can be told apart within its neighbours. */
export function plotNumber(value: number): string {
  if (value !== 0 && (Math.abs(value) >= 1e7 || Math.abs(value) < 1e-4)) return value.toExponential(3);
  return String(Number(value.toPrecision(7)));
}

export function lineWords({ unit, words }: PlotLine, value: number): string {
  if (words !== undefined) return words(value);
  return unit === null ? plotNumber(value) : `${plotNumber(value)} ${unit}`;
}
