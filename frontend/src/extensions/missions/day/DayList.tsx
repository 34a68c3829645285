import { Anchor, Group, Text } from "@mantine/core";
import { Link } from "react-router";
import { useNaming } from "../../../fleet/context";
import { Section } from "../../../ui/Section";
import { MissionBadge, missionPath } from "../MissionCard";
import { hasEnded } from "../queue";
import { takerWords } from "../words";
import { type Bar, keyOf, type Row } from "./bars";
import classes from "./day.module.css";
import { barName, periodWords, plannedWords, stateWords, stepStates } from "./dayWords";

/** The missions of a day as a list for each robot, the latest first, then what is planned. */
export function DayList({ rows }: { rows: readonly Row[] }) {
  const naming = useNaming();
  return rows.map(({ robot, group, bars, next }) => (
    <Section
      key={robot ?? `any of ${group}`}
      title={takerWords({ robot, group }, naming)}
      aside={
        next > 0 && (
          <Anchor component={Link} to="/ui/missions" size="sm">
            {next} next
          </Anchor>
        )
      }
    >
      {bars.length === 0 ? (
        <Text size="sm" c="dimmed">
          No missions today
        </Text>
      ) : (
        <ul className={classes.list} aria-label={`Missions of ${takerWords({ robot, group }, naming)}`}>
          {[...begun(bars).reverse(), ...bars.filter(({ kind }) => kind === "planned")].map((bar) => (
            <Entry key={keyOf(bar)} bar={bar} />
          ))}
        </ul>
      )}
    </Section>
  ));
}

function begun(bars: readonly Bar[]): Bar[] {
  return bars.filter(({ kind }) => kind === "mission");
}

function Entry({ bar }: { bar: Bar }) {
  if (bar.kind === "planned")
    return (
      <li className={classes.entry} data-kind="planned">
        <Text size="sm" className="tabular">
          {plannedWords(bar)}
        </Text>
        <Anchor component={Link} to="/ui/missions/schedules" fw={600} size="sm">
          {barName(bar)}
        </Anchor>
      </li>
    );
  const { mission } = bar;
  return (
    <li className={classes.entry} data-kind="mission" data-status={mission.status}>
      <Text size="sm" className="tabular">
        {periodWords(bar, hasEnded(mission))}
      </Text>
      <Group gap="xs">
        <Anchor component={Link} to={missionPath(mission)} fw={600} size="sm">
          {barName(bar)}
        </Anchor>
        <MissionBadge status={mission.status} />
      </Group>
      {!hasEnded(mission) || mission.error !== null ? <Text size="sm">{stateWords(mission)}</Text> : null}
      <Text size="xs" component="div" className={classes.steps}>
        {stepStates(mission).map(({ path, words, state, status }) => (
          <span key={path} className={classes.step}>
            <span className={classes.part} data-state={status} />
            {words}: {state}
          </span>
        ))}
      </Text>
    </li>
  );
}
