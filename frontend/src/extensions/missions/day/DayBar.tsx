import { Menu, Stack, Text, Tooltip } from "@mantine/core";
import type { CSSProperties } from "react";
import { Link } from "react-router";
import { clockOf } from "../../../ui/time";
import { missionPath } from "../MissionCard";
import { hasEnded } from "../queue";
import { type Bar, type Bundle, keyOf, type MissionBar, type Period, partsOf, placeOf } from "./bars";
import classes from "./day.module.css";
import { barName, barWords, periodWords, plannedWords, SIGNS, stateWords, stepStates } from "./dayWords";

interface DayBarProps {
  bar: Bar | Bundle;
  /** Of its row, from 0. */
  lane: number;
  axis: Period;
  /** In ms. */
  now: number;
}

/** A mission that leads to its page, a planned one that leads to its schedule, or several that have no room. */
export function DayBar({ bar, lane, axis, now }: DayBarProps) {
  const { left, width } = placeOf(bar, axis);
  const style = { "--left": `${left}%`, "--width": `${width}%`, "--lane": lane } as CSSProperties;
  return (
    <li className={classes.item} style={style}>
      {bar.kind === "bundle" ? (
        <BundleMenu bundle={bar} />
      ) : (
        <Tooltip label={<Details bar={bar} />} multiline maw={320} openDelay={200}>
          <Link
            to={pathOf(bar)}
            className={classes.bar}
            data-kind={bar.kind}
            data-status={bar.kind === "mission" ? bar.mission.status : undefined}
            aria-label={barWords(bar)}
          >
            <span className={classes.name}>
              {bar.kind === "mission" && <span className={classes.sign}>{SIGNS[bar.mission.status]}</span>}
              <span className={classes.words}>{barName(bar)}</span>
            </span>
            <span className={classes.state}>
              {bar.kind === "mission" ? stateWords(bar.mission) : plannedWords(bar)}
            </span>
            {bar.kind === "mission" && <Parts bar={bar} now={now} />}
          </Link>
        </Tooltip>
      )}
    </li>
  );
}

function pathOf(bar: Bar): string {
  return bar.kind === "mission" ? missionPath(bar.mission) : "/ui/missions/schedules";
}

/** The steps that have begun, by their states. */
function Parts({ bar, now }: { bar: MissionBar; now: number }) {
  return (
    <span className={classes.parts}>
      {partsOf(bar.mission, now).map(({ step, ...period }) => {
        const { left, width } = placeOf(period, bar);
        return (
          <span
            key={step.path}
            className={classes.part}
            data-state={step.status}
            style={{ left: `${left}%`, width: `${width}%` }}
          />
        );
      })}
    </span>
  );
}

function Details({ bar }: { bar: Bar }) {
  if (bar.kind === "planned") return barWords(bar);
  const { mission } = bar;
  return (
    <Stack gap={2}>
      <Text size="sm" fw={600}>
        {barName(bar)}
      </Text>
      <Text size="sm">
        {periodWords(bar, hasEnded(mission))}. {stateWords(mission)}
      </Text>
      {stepStates(mission)
        .slice(0, 8)
        .map(({ path, words, state, sign }) => (
          <Text key={path} size="xs">
            {sign} {words}: {state}
          </Text>
        ))}
    </Stack>
  );
}

function BundleMenu({ bundle: { bars, ...period } }: { bundle: Bundle }) {
  return (
    <Menu position="bottom-start" shadow="md" width={280}>
      <Menu.Target>
        <button
          type="button"
          className={classes.bar}
          data-kind="bundle"
          aria-label={`${bars.length} missions, ${periodWords(period)}`}
        >
          <span className={classes.name}>{bars.length}</span>
          <span className={classes.state}>missions</span>
        </button>
      </Menu.Target>
      <Menu.Dropdown className={classes.menu ?? ""}>
        {bars.map((bar) => (
          <Menu.Item key={keyOf(bar)} component={Link} to={pathOf(bar)}>
            {bar.kind === "mission"
              ? `${clockOf(bar.from)} ${barName(bar)}: ${stateWords(bar.mission)}`
              : `${barName(bar)}. ${plannedWords(bar)}`}
          </Menu.Item>
        ))}
      </Menu.Dropdown>
    </Menu>
  );
}
