import { Button, SegmentedControl, Skeleton, Stack, Text } from "@mantine/core";
import { keepPreviousData } from "@tanstack/react-query";
import { useEffect } from "react";
import { Link } from "react-router";
import { useFleet, useFleetLive } from "../../fleet/context";
import { GroupSelect, RobotSelect } from "../../fleet/RobotFields";
import { TagSelect } from "../../goals/TagSelect";
import { useAddress } from "../../ui/address";
import { Empty } from "../../ui/Empty";
import { Trouble } from "../../ui/errors";
import { Fact, FactList } from "../../ui/Fact";
import { fixed } from "../../ui/numbers";
import { useAnswer } from "../../ui/requests";
import { PageTitle, Section } from "../../ui/Section";
import { Time } from "../../ui/Time";
import { TimeRangeField } from "../../ui/TimeRangeField";
import { sentence } from "../../ui/text";
import { useZone, zoneName } from "../../ui/zone";
import { CountLink, DurationLink, ENDS, RateLink, tenths } from "./cells";
import { DayPlots } from "./DayPlots";
import { DockingTimes } from "./DockingTrend";
import { ErrorTable, GroupTable } from "./GroupTable";
import type { GoalCounts, Statistics } from "./requests";
import { fetchStatistics } from "./requests";
import classes from "./statistics.module.css";
import { GROUPINGS, type Grouping, isTooLong, MAX_DAYS, statisticsView, toQuery, type View } from "./view";

/** How goals ended, by day, robot or action; every number leads to its goals. */
export default function StatisticsPage() {
  const [view, change] = useAddress(statisticsView);
  const { data, error, isPlaceholderData, tooLong, live, refetch, dataUpdatedAt } = useStatistics(view);
  return (
    <Stack gap="md">
      <PageTitle title="Statistics" help="extensions/statistics#on-the-dashboard" />
      <Controls view={view} change={change} />
      <Trouble what="The statistics could not be loaded" error={error} onRetry={() => void refetch()} />
      {tooLong ? (
        <Text role="status">
          Days are shown for at most {MAX_DAYS} days. Choose fewer, or group by robot or action.
        </Text>
      ) : data === undefined ? (
        error === null && <StatisticsSkeleton />
      ) : (
        <Stack gap="md" aria-busy={isPlaceholderData} data-testid="statistics">
          <Text size="sm" c="dimmed" role="status">
            {live ? "As of" : "Not live: as of"} <Time value={dataUpdatedAt} />, days in {zoneName()}
          </Text>
          {data.total.ended === 0 ? (
            <NoGoals view={view} change={change} />
          ) : (
            <Shown statistics={data} view={view} />
          )}
        </Stack>
      )}
    </Stack>
  );
}

function Shown({ statistics, view }: { statistics: Statistics; view: View }) {
  // By day they are the same statistics.
  const { data: byDay, tooLong } = useStatistics({ ...view, by: "day" });
  return (
    <>
      <Summary total={statistics.total} />
      {byDay !== undefined && !tooLong && <DayPlots statistics={byDay} />}
      <Section title={`By ${GROUPINGS[statistics.by].toLowerCase()}`}>
        <GroupTable statistics={statistics} />
      </Section>
      <Section title="Errors">
        <ErrorTable total={statistics.total} />
      </Section>
      <DockingTimes view={view} />
    </>
  );
}

function NoGoals({ view, change }: ControlsProps) {
  const narrowed = view.robot !== null || view.group !== null || view.tags.length > 0;
  const month = { last: "30d", since: null, until: null } as const;
  return (
    <Empty
      title="No goal ended"
      examples={
        <>
          {view.time.last !== month.last && (
            <Button variant="default" onClick={() => change({ time: month })}>
              Show 30 days
            </Button>
          )}
          {narrowed && (
            <Button variant="default" onClick={() => change({ robot: null, group: null, tags: [] })}>
              Show all robots and tags
            </Button>
          )}
          <Button component={Link} to="/ui/goals" variant="default">
            All goals
          </Button>
        </>
      }
    >
      Goals that were created in this time are counted here once they have ended: in plots, and in tables by
      day, robot and action.
    </Empty>
  );
}

function StatisticsSkeleton() {
  return (
    <Stack gap="md" role="status" aria-busy="true" aria-label="The statistics are loading">
      <Skeleton height={150} />
      <Skeleton height={320} />
    </Stack>
  );
}

interface ControlsProps {
  view: View;
  change: (part: Partial<View>) => void;
}

const BY = Object.entries(GROUPINGS).map(([value, label]) => ({ value, label }));

/** Which goals, and what they are grouped by. */
function Controls({ view, change }: ControlsProps) {
  const { store } = useFleet();
  return (
    <section aria-label="Choose goals" className={classes.controls}>
      <TimeRangeField
        value={view.time}
        onChange={(time) => change({ time })}
        now={() => store.gatewayNow()}
      />
      <SegmentedControl
        aria-label="Group by"
        data={BY}
        value={view.by}
        onChange={(by) => change({ by: by as Grouping })}
      />
      <RobotSelect aria-label="Robot" robot={view.robot} onRobot={(robot) => change({ robot })} />
      <GroupSelect aria-label="Group" group={view.group} onGroup={(group) => change({ group })} />
      <TagSelect aria-label="Tag" any="All tags" chosen={view.tags} onTags={(tags) => change({ tags })} />
    </section>
  );
}

/** All goals of the time together. */
function Summary({ total }: { total: GoalCounts }) {
  return (
    <Section title="All goals">
      <div className={classes.summary}>
        <FactList>
          <Fact name="Ended">
            <CountLink counts={total} statuses={ENDS} />
          </Fact>
          <Fact name="Success rate">
            <RateLink counts={total} />
          </Fact>
          <Fact name="Median duration">
            <DurationLink counts={total} of="median" unit=" s" />
          </Fact>
          <Fact name="90th percentile">
            <DurationLink counts={total} of="p90" unit=" s" />
          </Fact>
          <Fact name="Retries per goal">{tenths(total.mean_retries)}</Fact>
          {ENDS.map((status) => (
            <Fact key={status} name={sentence(status)}>
              <CountLink counts={total} statuses={[status]} />
            </Fact>
          ))}
        </FactList>
      </div>
      <Text size="sm" c="dimmed">
        Success rate: succeeded goals among the {fixed(total.ended - total.statuses.canceled, 0)} that ended
        and were not canceled. Durations are those of succeeded goals.
      </Text>
    </Section>
  );
}

const EVERY_MS = 60_000;

/** How goals ended; asked for again every minute, and when the gateway is back. */
function useStatistics(view: View) {
  const { http, store } = useFleet();
  const live = useFleetLive();
  const zone = useZone();
  const tooLong = isTooLong(view, store.gatewayNow());
  const possible = !tooLong;
  const query = useAnswer({
    queryKey: ["statistics", zone, statisticsView.write(view).toString()],
    queryFn: ({ signal }) => fetchStatistics(http, toQuery(view, store.gatewayNow()), signal),
    enabled: possible,
    placeholderData: keepPreviousData,
    refetchInterval: live ? EVERY_MS : false,
  });
  const { refetch } = query;
  useEffect(() => {
    if (live && possible) void refetch({ cancelRefetch: false });
  }, [live, possible, refetch]);
  return { ...query, live, tooLong };
}
