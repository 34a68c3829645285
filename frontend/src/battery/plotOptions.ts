import type uPlot from "uplot";
import { WINDOW_S } from "./series";

export interface PlotColors {
  text: string;
  grid: string;
  percentage: string;
  voltage: string;
}

export const PLOT_COLORS: Record<"light" | "dark", PlotColors> = {
  light: { text: "#343a40", grid: "#dee2e6", percentage: "#1864ab", voltage: "#a61e4d" },
  dark: { text: "#dee2e6", grid: "#424242", percentage: "#74c0fc", voltage: "#ffa8c5" },
};

const MINUTES = WINDOW_S / 60;
const ROWS = 4;
const TIDY_V = 0.05;
const FONT = "12px system-ui, sans-serif";
const clock = new Intl.DateTimeFormat(undefined, { hour: "2-digit", minute: "2-digit", second: "2-digit" });

/** Room above and below the voltages, so that a steady one is not a line on the edge; every mark on a multiple of 0.05. */
export function voltageRange(min: number | null, max: number | null): [number, number] {
  if (min === null || max === null) return [0, 1];
  const room = Math.max((max - min) * 0.15, Math.abs(max) * 0.05, 0.1);
  const low = Math.floor((min - room) / TIDY_V) * TIDY_V;
  const step = Math.ceil((max + room - low) / ROWS / TIDY_V) * TIDY_V;
  return [low, low + ROWS * step];
}

/** `parts` + 1 marks from `min` to `max`, so that both scales share the grid's lines. */
export function evenly(min: number, max: number, parts: number): number[] {
  return Array.from({ length: parts + 1 }, (_, index) => min + ((max - min) * index) / parts);
}

/** @param now The right edge of the plot, s since 1970. */
export function plotOptions(
  width: number,
  height: number,
  colors: PlotColors,
  now: () => number,
): uPlot.Options {
  const axis = { stroke: colors.text, font: FONT, ticks: { stroke: colors.grid } };
  const series = { width: 2, spanGaps: false };
  return {
    width,
    height,
    legend: { live: true },
    cursor: { drag: { x: false, y: false }, points: { size: 7 } },
    scales: {
      x: { time: true, range: () => [now() - WINDOW_S, now()] },
      percent: { range: [0, 100] },
      volt: { range: (_plot, min, max) => voltageRange(min, max) },
    },
    axes: [
      {
        ...axis,
        grid: { stroke: colors.grid, width: 1 },
        splits: (_plot, _axis, min, max) => evenly(min, max, MINUTES),
        values: () => ["−5 min", "−4", "−3", "−2", "−1", "now"],
      },
      {
        ...axis,
        scale: "percent",
        size: 56,
        grid: { stroke: colors.grid, width: 1 },
        splits: (_plot, _axis, min, max) => evenly(min, max, ROWS),
        values: (_plot, splits) => splits.map((split) => `${split} %`),
      },
      {
        ...axis,
        scale: "volt",
        side: 1,
        size: 62,
        grid: { show: false },
        splits: (_plot, _axis, min, max) => evenly(min, max, ROWS),
        values: (_plot, splits) => splits.map((split) => `${split.toFixed(2)} V`),
      },
    ],
    series: [
      { label: "Time", value: (_plot, value) => (value === null ? "–" : clock.format(value * 1000)) },
      {
        ...series,
        label: "Percentage",
        scale: "percent",
        stroke: colors.percentage,
        value: (_plot, value) => (value === null ? "–" : `${value.toFixed(1)} %`),
      },
      {
        ...series,
        label: "Voltage",
        scale: "volt",
        stroke: colors.voltage,
        dash: [6, 4],
        value: (_plot, value) => (value === null ? "–" : `${value.toFixed(2)} V`),
      },
    ],
  };
}
