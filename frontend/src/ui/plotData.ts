import type uPlot from "uplot";
import { alike, COMPARED, type Digits, decimalsOf, NO_DIGITS, withNumber } from "./numbers";
import { type BAND_COLORS, PLOT_COLORS } from "./tokens";

/** What a plot draws, kept outside of React: it is read again only when the version has changed. */
export interface PlotSource {
  readonly version: number;
  /** The x values, ascending, then those of each line; null is a gap. */
  read(): [number[], ...(number | null)[][]];
}

/** Points of a uPlot line: where they are too close together for each to have a dot, those without a neighbour have one. */
export const POINTS: uPlot.Series.Points = {
  filter: (plot, series, shown) => (shown ? null : isolated(plot.data[series] ?? [])),
};

/** Where a value stands between gaps, so that no line leads to it. */
export function isolated(values: ArrayLike<number | null | undefined>): number[] {
  return Array.from(values, (_, index) => index).filter(
    (index) => values[index] != null && values[index - 1] == null && values[index + 1] == null,
  );
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
  /** What the axis shows at least, so that noise does not look like motion. */
  least?: readonly [number, number];
}

/**
 * Room above and below the values, so that a steady one is no line on the edge.
 *
 * @param least What is shown at least.
 */
export function roomyRange(
  min: number | null,
  max: number | null,
  least?: readonly [number, number],
): [number, number] {
  if (least !== undefined)
    return roomyRange(Math.min(min ?? least[0], least[0]), Math.max(max ?? least[1], least[1]));
  if (min === null || max === null) return [0, 1];
  const room = max > min ? (max - min) * 0.08 : Math.max(Math.abs(max) * 0.05, 0.5);
  return [min - room, max + room];
}

/** The numbers at an axis, with as many decimals as the step from one to the next has. */
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

const FONT = "12px system-ui, sans-serif";

const [TICK, GAP] = [6, 4];

/** Room right of the last label's middle, for half of `1:02:05.000`. */
export const LABEL_OVERHANG = 34;

/** How an axis of any plot looks in a colour scheme. */
export function plotAxis(scheme: "light" | "dark"): uPlot.Axis {
  const { text, grid } = PLOT_COLORS[scheme];
  return {
    stroke: text,
    font: FONT,
    gap: GAP,
    ticks: { stroke: grid, size: TICK },
    grid: { stroke: grid, width: 1 },
  };
}

let canvas: CanvasRenderingContext2D | null | undefined;

/** How wide a vertical axis with these labels is, so that none of them is clipped (CSS pixels). */
export function axisWidth(labels: readonly string[] | null): number {
  canvas ??= document.createElement("canvas").getContext("2d");
  if (canvas === null) return 0;
  canvas.font = FONT;
  const widths = (labels ?? []).map((label) => canvas?.measureText(label).width ?? 0);
  return Math.ceil(Math.max(24, ...widths)) + TICK + GAP + 2;
}
