import { Anchor, Text, useComputedColorScheme } from "@mantine/core";
import { Link } from "react-router";
import { codeWords } from "../../goal/words";
import { fixed } from "../../ui/numbers";
import { Section } from "../../ui/Section";
import { LINE_COLORS } from "../../ui/tokens";
import { ENDS, goalsLink, percent, tenths } from "./cells";
import { DayPlot, type Geometry, WholeColumn } from "./DayPlot";
import { durationMarks, errorMarks, goalsWords, kindsOf, type Mark, rateMarks, roundTicks } from "./plots";
import classes from "./plots.module.css";
import type { Statistics } from "./requests";

const RATES = [0, 0.25, 0.5, 0.75, 1];

/** How goals ended, day by day. The table has the same numbers. */
export function DayPlots({ statistics: { groups, total } }: { statistics: Statistics }) {
  const scheme = useComputedColorScheme("light");
  const days = groups.map(({ key }) => key);
  const durations = durationMarks(groups);
  const kinds = kindsOf(total);
  const errors = errorMarks(groups, kinds);
  const colorOf = (kind: number) =>
    LINE_COLORS[scheme][kind % LINE_COLORS[scheme].length] ?? "var(--mantine-color-dimmed)";
  const count = errors.reduce((sum, { from, to }) => sum + to - from, 0);
  return (
    <Section title="Over time">
      <div className={classes.plots}>
        <DayPlot
          title="Success rate"
          summary={percent(total.success_rate)}
          days={days}
          marks={rateMarks(groups)}
          ticks={RATES}
          tickWords={(rate) => `${fixed(rate * 100, 0)} %`}
          draw={(mark, geometry) => (
            <>
              <WholeColumn column={mark.column} geometry={geometry} />
              <Bar mark={mark} geometry={geometry} className={classes.good} />
              <Bar mark={{ ...mark, from: mark.to, to: 1 }} geometry={geometry} className={classes.bad} />
            </>
          )}
        />
        <DayPlot
          title="Duration"
          summary={`median ${tenths(total.duration_s.median, " s")}`}
          days={days}
          marks={durations}
          ticks={roundTicks(Math.max(0, ...durations.map(({ to }) => to)))}
          tickWords={(seconds) => `${fixed(seconds, seconds % 1 === 0 ? 0 : 1)} s`}
          behind={(geometry) => <Band marks={durations} geometry={geometry} />}
          draw={(mark, geometry) => (
            <>
              <WholeColumn column={mark.column} geometry={geometry} />
              <line
                className={classes.spread}
                x1={geometry.x(mark.column)}
                x2={geometry.x(mark.column)}
                y1={geometry.y(mark.from)}
                y2={geometry.y(mark.to)}
              />
              <circle
                className={classes.point}
                cx={geometry.x(mark.column)}
                cy={geometry.y(mark.at ?? 0)}
                r={4}
              />
            </>
          )}
        />
        {count === 0 ? (
          <figure className={classes.figure}>
            <figcaption className={classes.caption}>
              <strong>Errors</strong>
            </figcaption>
            <Text size="sm" c="dimmed">
              No goal ended with an error.
            </Text>
          </figure>
        ) : (
          <DayPlot
            title="Errors"
            summary={goalsWords(count)}
            days={days}
            marks={errors}
            ticks={roundTicks(highest(errors), true)}
            tickWords={(value) => fixed(value, 0)}
            draw={(mark, geometry) => (
              <Bar
                mark={mark}
                geometry={geometry}
                className={classes.part}
                color={mark.kind < 0 ? undefined : colorOf(mark.kind)}
              />
            )}
            legend={
              <ul className={classes.legend} aria-label="Kinds of errors">
                {kinds.map((code, kind) => (
                  <li key={code}>
                    <span className={classes.swatch} style={{ background: colorOf(kind) }} />
                    <Anchor component={Link} to={goalsLink(total, ENDS, code)} inherit>
                      {codeWords(code)}
                    </Anchor>
                  </li>
                ))}
                {errors.some(({ kind }) => kind < 0) && (
                  <li>
                    <span className={classes.swatch} />
                    Other errors
                  </li>
                )}
              </ul>
            }
          />
        )}
      </div>
      <Text size="sm" c="dimmed">
        Duration: the points are medians; eight of ten goals are inside the band. Press a bar or a point to
        list its goals.
      </Text>
    </Section>
  );
}

interface BarProps {
  mark: Mark;
  geometry: Geometry;
  className: string | undefined;
  color?: string | undefined;
}

function Bar({ mark: { column, from, to }, geometry, className, color }: BarProps) {
  const [upper, lower] = [geometry.y(to), geometry.y(from)];
  return (
    <rect
      className={className}
      style={color === undefined ? undefined : { fill: color }}
      x={geometry.x(column) - geometry.bar / 2}
      y={upper}
      width={geometry.bar}
      height={Math.max(0, lower - upper)}
    />
  );
}

/** The spread and the median of days that follow each other. */
function Band({ marks, geometry: { x, y } }: { marks: readonly Mark[]; geometry: Geometry }) {
  return runs(marks).map((run) => {
    const line = (value: (mark: Mark) => number) => run.map((mark) => `${x(mark.column)},${y(value(mark))}`);
    const edge = [...line(({ to }) => to), ...line(({ from }) => from).reverse()];
    return (
      <g key={run[0]?.key}>
        <polygon className={classes.band} points={edge.join(" ")} />
        <polyline className={classes.median} points={line(({ at }) => at ?? 0).join(" ")} />
      </g>
    );
  });
}

/** The marks in runs of days without a gap. */
function runs(marks: readonly Mark[]): Mark[][] {
  const found: Mark[][] = [];
  for (const mark of marks) {
    const run = found.at(-1);
    if (run?.at(-1)?.column === mark.column - 1) run.push(mark);
    else found.push([mark]);
  }
  return found;
}

function highest(marks: readonly Mark[]): number {
  return Math.max(0, ...marks.map(({ to }) => to));
}
