import { Button, useComputedColorScheme } from "@mantine/core";
import { useElementSize, useReducedMotion } from "@mantine/hooks";
import { useEffect, useRef, useState } from "react";
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { onBeat } from "./beat";
import classes from "./LinePlot.module.css";
import { decimalsOf } from "./numbers";
import { axisNumbers, lineWords, type PlotLine, type PlotSource, roomyRange } from "./plotData";
import { axisWidth, LABEL_OVERHANG, plotAxis } from "./plotLook";
import { watchSight } from "./sight";

/** A plot with its legend is this much higher than what it draws in. */
export const LEGEND_HEIGHT = 34;

/** Of an x value in the legend. */
const X_DECIMALS = 3;
/** From one x label to the next, at least (CSS pixels). */
const X_SPACE = 80;
const REDRAW_MS = 200;
const SLOW_REDRAW_MS = 1000;
const COLORS = {
  light: ["#1864ab", "#a61e4d", "#2b8a3e", "#862e9c"],
  dark: ["#74c0fc", "#ffa8c5", "#8ce99a", "#e599f7"],
} as const;
const DASHES = [[], [6, 4], [2, 3], [10, 3, 2, 3]];

interface LinePlotProps {
  source: PlotSource;
  /** At most four; the same array while they are the same. */
  lines: readonly PlotLine[];
  /** What an x value says in the legend, and below the axis; a function that stays the same. */
  xLabel: string;
  formatX: (x: number, decimals: number) => string;
  /** What is drawn, to a screen reader. */
  label: string;
  height?: number;
}

/** Lines over something that ascends, renewed five times a second at most. Dragging across zooms in. */
export default function LinePlot({ source, lines, xLabel, formatX, label, height = 240 }: LinePlotProps) {
  const scheme = useComputedColorScheme("light");
  const reducedMotion = useReducedMotion();
  const { ref: frameRef, width } = useElementSize<HTMLDivElement>();
  const boxRef = useRef<HTMLDivElement>(null);
  const plotRef = useRef<uPlot | null>(null);
  const [zoomed, setZoomed] = useState(false);
  const zoomedRef = useRef(false);

  useEffect(() => {
    if (boxRef.current === null || width === 0) return;
    const zoom = (yes: boolean) => {
      zoomedRef.current = yes;
      setZoomed(yes);
    };
    const options = plotOptions({ width, height, lines, xLabel, formatX, scheme, zoom });
    const plot = new uPlot(options, undefined, boxRef.current);
    plotRef.current = plot;
    zoom(false);
    let drawn = -1;
    let inSight = true;
    const draw = () => {
      if (!inSight || source.version === drawn) return;
      drawn = source.version;
      const { min, max } = plot.scales.x ?? {};
      plot.setData(source.read(), !zoomedRef.current);
      if (zoomedRef.current && min != null && max != null) plot.setScale("x", { min, max });
      // After what setData has put off until then.
      queueMicrotask(() => tellLatest(plot));
    };
    draw();
    const unwatch = watchSight(boxRef.current, (now) => {
      inSight = now;
      draw();
    });
    const stop = onBeat(reducedMotion ? SLOW_REDRAW_MS : REDRAW_MS, draw);
    return () => {
      unwatch();
      stop();
      plot.destroy();
      plotRef.current = null;
    };
  }, [source, lines, xLabel, formatX, height, scheme, width, reducedMotion]);

  const showAll = () => {
    zoomedRef.current = false;
    setZoomed(false);
    plotRef.current?.setData(source.read(), true);
  };
  return (
    <div ref={frameRef} className={classes.frame}>
      {zoomed && (
        <Button variant="default" size="compact-sm" className={classes.whole} onClick={showAll}>
          Show all
        </Button>
      )}
      <div
        ref={boxRef}
        className={classes.plot}
        style={{ minHeight: height + LEGEND_HEIGHT }}
        role="img"
        aria-label={label}
        data-testid="plot"
      />
    </div>
  );
}

/** Without a pointer on the plot, its legend tells the latest values. */
function tellLatest(plot: uPlot): void {
  const last = plot.data[0].length - 1;
  if ((plot.cursor.left ?? -1) < 0 && last >= 0) plot.setLegend({ idx: last });
}

interface Look {
  width: number;
  height: number;
  lines: readonly PlotLine[];
  xLabel: string;
  formatX: (x: number, decimals: number) => string;
  scheme: "light" | "dark";
  zoom: (yes: boolean) => void;
}

function plotOptions({ width, height, lines, xLabel, formatX, scheme, zoom }: Look): uPlot.Options {
  const axis = plotAxis(scheme);
  const colors = COLORS[scheme];
  return {
    width,
    height,
    cursor: {
      drag: { x: true, y: false },
      points: { size: 7 },
      bind: {
        dblclick: (_plot, _target, handle) => (event) => {
          zoom(false);
          return handle(event);
        },
      },
    },
    hooks: { setSelect: [(plot) => plot.select.width > 0 && zoom(true)], setCursor: [tellLatest] },
    padding: [8, LABEL_OVERHANG, 0, 0],
    scales: { x: { time: false }, y: { range: (_plot, min, max) => roomyRange(min, max) } },
    axes: [
      {
        ...axis,
        space: X_SPACE,
        values: (_plot, splits, _axis, _space, step) =>
          splits.map((split) => formatX(split, decimalsOf(step))),
      },
      {
        ...axis,
        size: (_plot, labels) => axisWidth(labels),
        values: (_plot, splits, _axis, _space, step) => axisNumbers(splits, step),
      },
    ],
    series: [
      { label: xLabel, value: (_plot, value) => (value === null ? "–" : formatX(value, X_DECIMALS)) },
      ...lines.map((line, index) => ({
        label: line.label,
        stroke: colors[index % colors.length] ?? colors[0],
        dash: DASHES[index % DASHES.length] ?? [],
        width: 2,
        spanGaps: false,
        value: (_plot: uPlot, value: number | null) => (value === null ? "–" : lineWords(line, value)),
      })),
    ],
  };
}
