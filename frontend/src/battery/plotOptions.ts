import uPlot from "uplot";
import type { Quantity } from "../store/batterySeries";
import { fixed } from "../ui/numbers";
import { plotAxis } from "../ui/plotData";
import type { Zone } from "../ui/zone";
import { marks, rangeOf, SHAPES } from "./quantities";
import { formatMark } from "./view";

/** Of the band between the least and the most. */
const BAND_ALPHA = "40";
/** Room for `23:59:59` and some more, in CSS pixels. */
const MARK_SPACE = 80;

export interface PlotLook {
  scheme: "light" | "dark";
  zone: Zone;
}

export interface PlotEvents {
  /** The span that is shown, s since 1970. */
  span: () => [number, number];
  /** Dragged across, s since 1970. */
  onSelect: (from: number, to: number) => void;
  /** The crosshair is on another point, or on none. */
  onCursor: (index: number | null) => void;
}

/** One quantity over time: its mean, and the band from the least to the most where a point is more than one measurement. */
export function plotOptions(
  quantity: Quantity,
  size: { width: number; height: number },
  { scheme, zone }: PlotLook,
  syncKey: string,
  { span, onSelect, onCursor }: PlotEvents,
): uPlot.Options {
  const { decimals, [scheme]: color } = SHAPES[quantity];
  const axis = plotAxis(scheme);
  const edge = { width: 0, points: { show: false } };
  return {
    ...size,
    // Where the marks of the time axis are.
    ...(zone === "utc" ? { tzDate: (timeS: number) => uPlot.tzDate(new Date(timeS * 1000), "UTC") } : {}),
    legend: { show: false },
    padding: [8, 12, 0, 0],
    cursor: {
      drag: { x: true, y: false, setScale: false },
      points: { size: 7 },
      sync: { key: syncKey, setSeries: false },
      // What a double click does is decided outside.
      bind: { dblclick: () => null },
    },
    scales: {
      x: { time: true, range: () => span() },
      y: { range: (_plot, min, max) => rangeOf(quantity, min, max) },
    },
    axes: [
      {
        ...axis,
        space: MARK_SPACE,
        size: 30,
        values: (_plot, splits, _axis, _space, step) => splits.map((split) => formatMark(split, step)),
      },
      {
        ...axis,
        size: 52,
        splits: (_plot, _axis, min, max) => marks(min, max),
        values: (_plot, splits) => splits.map((split) => fixed(split, decimals)),
      },
    ],
    series: [
      {},
      { ...edge, label: "most" },
      { ...edge, label: "least" },
      { label: SHAPES[quantity].name, width: 2, stroke: color, spanGaps: false },
    ],
    bands: [{ series: [1, 2], fill: `${color}${BAND_ALPHA}` }],
    hooks: {
      setCursor: [(plot) => onCursor((plot.cursor.left ?? -1) < 0 ? null : (plot.cursor.idx ?? null))],
      setSelect: [
        (plot) => {
          const { left, width } = plot.select;
          if (width <= 0) return;
          plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          onSelect(plot.posToVal(left, "x"), plot.posToVal(left + width, "x"));
        },
      ],
    },
  };
}
