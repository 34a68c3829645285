import { Anchor, Button, Group, SegmentedControl, Text } from "@mantine/core";
import { useElementSize } from "@mantine/hooks";
import { type CSSProperties, useId, useState } from "react";
import { Link } from "react-router";
import { useNaming } from "../../../fleet/context";
import { robotPath } from "../../../fleet/names";
import { Section } from "../../../ui/Section";
import { Tool } from "../../../ui/Tool";
import { clockOf } from "../../../ui/time";
import { takerWords } from "../words";
import { axisOf, movedMiddle, SPANS, type Span, ticksOf } from "./axis";
import { keyOf, lanesOf, type Period, placeOf, type Row } from "./bars";
import { DayBar } from "./DayBar";
import classes from "./day.module.css";

const EARLIER = "M15.4 5 14 3.6 5.6 12l8.4 8.4 1.4-1.4-7-7Z";
const LATER = "M8.6 5 10 3.6 18.4 12 10 20.4 8.6 19l7-7Z";

/** In px: the shortest bar, and the room for the name of a time. */
const LEAST = 28;
const TICK = 64;
const MOST_LANES = 3;
/** The width of the axis before it is measured (px). */
const USUAL_WIDTH = 720;

interface DayChartProps {
  rows: readonly Row[];
  day: Period;
  /** In ms. */
  now: number;
}

/** A row for each robot with its missions on the axis of a day, or of a part of it. */
export function DayChart({ rows, day, now }: DayChartProps) {
  const [span, setSpan] = useState<Span>("day");
  /** Null: what is seen goes along with now. */
  const [middle, setMiddle] = useState<number | null>(null);
  const { ref, width } = useElementSize();
  const axis = axisOf(span, day, middle ?? now);
  const pixels = width || USUAL_WIDTH;
  const ticks = ticksOf(axis, day, pixels / TICK);
  const least = ((axis.to - axis.from) * LEAST) / pixels;
  const move = (by: -1 | 1) => setMiddle(movedMiddle(axis, by));
  return (
    <Section
      title={`${clockOf(axis.from)} – ${axis.to === day.to ? "24:00" : clockOf(axis.to)}`}
      aside={
        <Group gap="xs">
          {span !== "day" && (
            <>
              <Tool name="Earlier" path={EARLIER} disabled={axis.from <= day.from} onClick={() => move(-1)} />
              <Tool name="Later" path={LATER} disabled={axis.to >= day.to} onClick={() => move(1)} />
              <Button variant="default" size="compact-sm" onClick={() => setMiddle(null)}>
                Now
              </Button>
            </>
          )}
          <SegmentedControl
            aria-label="How much is seen"
            data={SPANS}
            value={span}
            onChange={(value) => setSpan(value as Span)}
          />
        </Group>
      }
    >
      <div className={classes.chart}>
        <div className={classes.axis} ref={ref} aria-hidden="true">
          {ticks
            .filter((tick) => tick < axis.to)
            .map((tick) => (
              <span key={tick} className={`tabular ${classes.tick}`} style={at(tick, axis)}>
                {clockOf(tick)}
              </span>
            ))}
        </div>
        <ol className={classes.rows} aria-label="Robots">
          {rows.map((row) => (
            <RobotRow
              key={row.robot ?? `any of ${row.group}`}
              row={row}
              lanes={lanesOf(row.bars, axis, least, MOST_LANES)}
              {...{ axis, ticks, now }}
            />
          ))}
        </ol>
      </div>
      <Legend />
    </Section>
  );
}

interface RobotRowProps {
  row: Row;
  lanes: ReturnType<typeof lanesOf>;
  axis: Period;
  ticks: readonly number[];
  now: number;
}

function RobotRow({ row: { robot, group, next }, lanes, axis, ticks, now }: RobotRowProps) {
  const id = useId();
  const name = takerWords({ robot, group }, useNaming());
  const isNowSeen = now >= axis.from && now < axis.to;
  return (
    <li className={classes.row} aria-labelledby={id}>
      <div className={classes.robot}>
        {robot === null ? (
          <Text id={id} size="sm" fw={600}>
            {name}
          </Text>
        ) : (
          <Anchor component={Link} to={robotPath(robot)} id={id} size="sm" fw={600}>
            {name}
          </Anchor>
        )}
        {next > 0 && (
          <Anchor component={Link} to="/ui/missions" size="xs">
            {next} next
          </Anchor>
        )}
      </div>
      <div className={classes.track} style={{ "--lanes": Math.max(lanes.length, 1) } as CSSProperties}>
        {ticks.map((tick) => (
          <span key={tick} className={classes.line} style={at(tick, axis)} />
        ))}
        <ul className={classes.bars} aria-label={`Missions of ${name}`}>
          {lanes.flatMap((lane, index) =>
            lane.map((bar) => <DayBar key={keyOf(bar)} bar={bar} lane={index} axis={axis} now={now} />),
          )}
        </ul>
        {isNowSeen && <span className={classes.now} style={at(now, axis)} />}
      </div>
    </li>
  );
}

function at(time: number, axis: Period): CSSProperties {
  return { left: `${placeOf({ from: time, to: time }, axis).left}%` };
}

const STEPS = [
  ["succeeded", "Step done"],
  ["running", "Step now"],
  ["failed", "Step failed"],
  ["skipped", "Step skipped or canceled"],
] as const;

/** What colors, frames and the line mean. */
function Legend() {
  return (
    <Group gap="md" className={classes.legend ?? ""}>
      {STEPS.map(([state, words]) => (
        <Group key={state} gap={6} wrap="nowrap">
          <span className={classes.part} data-state={state} />
          <Text size="xs">{words}</Text>
        </Group>
      ))}
      <Group gap={6} wrap="nowrap">
        <span className={classes.sample} />
        <Text size="xs">Planned by a schedule</Text>
      </Group>
      <Group gap={6} wrap="nowrap">
        <span className={classes.nowSample} />
        <Text size="xs">Now</Text>
      </Group>
    </Group>
  );
}
