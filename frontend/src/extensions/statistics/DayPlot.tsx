import { useElementSize } from "@mantine/hooks";
import { type KeyboardEvent, type ReactNode, useState } from "react";
import { Link } from "react-router";
import { dayWords } from "./cells";
import type { Mark } from "./plots";
import classes from "./plots.module.css";

const HEIGHT = 190;
const [TOP, RIGHT, BOTTOM, LEFT] = [8, 34, 24, 46];
/** The width of a plot where there is no layout, as in a test (px). */
const UNKNOWN_WIDTH = 480;
/** The least distance between the labels of two days (px). */
const LABEL_SPACE = 78;
const MAX_BAR = 44;

/** Where things are on a plot, in pixels. */
export interface Geometry {
  /** The middle of a day. */
  x: (column: number) => number;
  y: (value: number) => number;
  /** The width of a bar. */
  bar: number;
}

interface DayPlotProps {
  title: string;
  /** A summary of the plot, next to the title while no day is pointed at. */
  summary: ReactNode;
  days: readonly string[];
  marks: readonly Mark[];
  /** The values of the axis, ascending from 0; the last is the upper edge. */
  ticks: readonly number[];
  tickWords: (value: number) => string;
  /** Drawn behind the marks. */
  behind?: (geometry: Geometry) => ReactNode;
  draw: (mark: Mark, geometry: Geometry) => ReactNode;
  legend?: ReactNode;
}

/** A plot over days. Each mark is a link; the arrow keys go from one to the next. */
export function DayPlot({
  title,
  summary,
  days,
  marks,
  ticks,
  tickWords,
  behind,
  draw,
  legend,
}: DayPlotProps) {
  const { ref, width: measured } = useElementSize();
  const width = measured || UNKNOWN_WIDTH;
  const [pointed, setPointed] = useState<string | null>(null);
  const [entry, setEntry] = useState<string | null>(null);
  const step = (width - LEFT - RIGHT) / Math.max(1, days.length);
  const top = ticks.at(-1) ?? 1;
  const geometry: Geometry = {
    x: (column) => LEFT + (column + 0.5) * step,
    y: (value) => TOP + (1 - value / top) * (HEIGHT - TOP - BOTTOM),
    bar: Math.min(MAX_BAR, Math.max(1, step * 0.7)),
  };
  const every = Math.ceil(LABEL_SPACE / step);
  const shown = marks.find(({ key }) => key === pointed);
  // The newest day is where the keyboard enters, until another one was reached.
  const first = marks.find(({ key }) => key === entry) ?? marks.at(-1);
  return (
    <figure className={classes.figure} data-testid="day-plot">
      <figcaption className={classes.caption}>
        <strong>{title}</strong>
        <span className={classes.readout}>{shown?.label ?? summary}</span>
      </figcaption>
      <div ref={ref} className={classes.plot}>
        {/* biome-ignore lint/a11y/noSvgWithoutTitle: the caption names it, and a title would cover the plot as a tooltip */}
        <svg width={width} height={HEIGHT} onKeyDown={goToNext}>
          {/* biome-ignore lint/a11y/noAriaHiddenOnFocusable: a drawing cannot be focused */}
          <g aria-hidden="true">
            {ticks.map((tick) => (
              <g key={tick}>
                <line
                  className={classes.grid}
                  x1={LEFT}
                  x2={width - RIGHT}
                  y1={geometry.y(tick)}
                  y2={geometry.y(tick)}
                />
                <text
                  className={classes.label}
                  x={LEFT - 6}
                  y={geometry.y(tick)}
                  dy="0.35em"
                  textAnchor="end"
                >
                  {tickWords(tick)}
                </text>
              </g>
            ))}
            {days.map(
              (day, column) =>
                (days.length - 1 - column) % every === 0 && (
                  <text
                    key={day}
                    className={classes.label}
                    x={geometry.x(column)}
                    y={HEIGHT - 6}
                    textAnchor="middle"
                  >
                    {dayWords(day)}
                  </text>
                ),
            )}
            {behind?.(geometry)}
          </g>
          {marks.map((mark) => (
            <Link
              key={mark.key}
              to={mark.path}
              className={classes.mark}
              aria-label={mark.label}
              tabIndex={mark === first ? 0 : -1}
              onFocus={() => {
                setPointed(mark.key);
                setEntry(mark.key);
              }}
              onBlur={() => setPointed(null)}
              onPointerEnter={() => setPointed(mark.key)}
              onPointerLeave={() => setPointed(null)}
            >
              {draw(mark, geometry)}
            </Link>
          ))}
        </svg>
      </div>
      {legend}
    </figure>
  );
}

/** A place to press that is as high as the plot and as wide as a day. */
export function WholeColumn({ column, geometry }: { column: number; geometry: Geometry }) {
  const width = geometry.x(1) - geometry.x(0);
  return (
    <rect
      className={classes.hit}
      x={geometry.x(column) - width / 2}
      y={TOP}
      width={width}
      height={HEIGHT - TOP - BOTTOM}
      rx={3}
    />
  );
}

function goToNext(event: KeyboardEvent<SVGSVGElement>): void {
  const links = [...event.currentTarget.querySelectorAll<SVGAElement>("a")];
  const at = links.indexOf(event.target as SVGAElement);
  const last = links.length - 1;
  const next = { ArrowLeft: at - 1, ArrowRight: at + 1, Home: 0, End: last }[event.key];
  if (at < 0 || next === undefined) return;
  event.preventDefault();
  links[Math.min(last, Math.max(0, next))]?.focus();
}
