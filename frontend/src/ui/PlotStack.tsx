import { Button, useComputedColorScheme } from "@mantine/core";
import { useReducedMotion } from "@mantine/hooks";
import { type ReactNode, useEffect, useRef, useState } from "react";
import "uplot/dist/uPlot.min.css";
import { onBeat } from "../clock/beat";
import type { Crosshair } from "./crosshair";
import classes from "./PlotStack.module.css";
import type { PlotBand, PlotLine, PlotSource } from "./plotData";
import { watchSight } from "./sight";
import { type PlotPlace, StackedPlots } from "./stackedPlots";
import { LINE_COLORS } from "./tokens";
import { useLatest } from "./useLatest";

const REDRAW_MS = 200;
const SLOW_REDRAW_MS = 1000;

export interface PlotStackProps {
  source: PlotSource;
  /** A plot each; the same array while they are the same. */
  lines: readonly PlotLine[];
  /** What each plot shows, to a screen reader. */
  labels: readonly string[];
  /** The buttons next to the name of each line. */
  tools: readonly ReactNode[];
  bands: readonly PlotBand[];
  /** How far the x axis goes at least. */
  least: number;
  crosshair: Crosshair;
  /** What an x value says below the axis; a function that stays the same. */
  formatX: (x: number, decimals: number) => string;
  /** Clicked at that point of the source. */
  onPick: (x: number) => void;
  height: number;
}

/** Plots below each other over something that ascends, renewed five times a second at most. Dragging across zooms in. */
export default function PlotStack(props: PlotStackProps) {
  const { source, lines, labels, tools, bands, crosshair, formatX, height } = props;
  const scheme = useComputedColorScheme("light");
  const reducedMotion = useReducedMotion();
  const frame = useRef<HTMLDivElement>(null);
  const places = useRef<Partial<PlotPlace>[]>([]);
  const stack = useRef<StackedPlots | null>(null);
  const latest = useLatest(props);
  const [zoomed, setZoomed] = useState(false);

  useEffect(() => {
    const found = places.current.slice(0, lines.length) as PlotPlace[];
    // Without a width there is nothing to draw on, as in a test without a layout.
    if (frame.current === null || found.some(({ plot }) => !plot || plot.clientWidth === 0)) return;
    setZoomed(false);
    const made = new StackedPlots(found, {
      source,
      lines,
      height,
      scheme,
      crosshair,
      formatX,
      bands: () => latest.current.bands,
      least: () => latest.current.least,
      onZoom: setZoomed,
      onPick: (x) => latest.current.onPick(x),
    });
    stack.current = made;
    let inSight = true;
    const draw = () => {
      if (inSight) made.draw();
    };
    const unwatch = watchSight(frame.current, (now) => {
      inSight = now;
      draw();
    });
    const stop = onBeat(reducedMotion ? SLOW_REDRAW_MS : REDRAW_MS, draw);
    const resized = new ResizeObserver(() => made.resize());
    resized.observe(frame.current);
    return () => {
      resized.disconnect();
      unwatch();
      stop();
      made.destroy();
      stack.current = null;
    };
  }, [source, lines, height, scheme, crosshair, formatX, reducedMotion]);

  // biome-ignore lint/correctness/useExhaustiveDependencies: the bands are read from `latest`
  useEffect(() => stack.current?.redraw(), [bands]);

  return (
    <div ref={frame} className={classes.frame}>
      {lines.map((line, index) => (
        <figure key={line.label} className={classes.figure} data-testid="plot">
          <figcaption className={classes.caption}>
            <span
              className={classes.mark}
              style={{ background: LINE_COLORS[scheme][index % LINE_COLORS[scheme].length] }}
            />
            <span className={classes.name} title={line.label}>
              {line.label}
            </span>
            <span
              className={classes.value}
              data-testid="plot-value"
              ref={(element) => {
                if (element !== null) places.current[index] = { ...places.current[index], value: element };
              }}
            />
            {tools[index]}
            {zoomed && index === 0 && (
              <Button variant="default" size="compact-sm" ms="auto" onClick={() => stack.current?.showAll()}>
                Show all
              </Button>
            )}
          </figcaption>
          <div
            className={classes.plot}
            style={{ minHeight: height }}
            role="img"
            aria-label={labels[index]}
            ref={(element) => {
              if (element !== null) places.current[index] = { ...places.current[index], plot: element };
            }}
          />
        </figure>
      ))}
    </div>
  );
}
