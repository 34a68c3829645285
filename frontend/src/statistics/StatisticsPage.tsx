import { Skeleton, Stack, Text } from "@mantine/core";
import { useMemo } from "react";
import { useSearchParams } from "react-router";
import type { Statistics } from "../api/types";
import { Trouble } from "../ui/errors";
import { PageTitle } from "../ui/PageTitle";
import { Section } from "../ui/Section";
import { Time } from "../ui/Time";
import { zoneName } from "../ui/zone";
import { Controls } from "./Controls";
import { ErrorTable } from "./ErrorTable";
import { GroupTable } from "./GroupTable";
import { Summary } from "./Summary";
import { useStatistics } from "./useStatistics";
import { GROUPINGS, MAX_DAYS, readView, writeView } from "./view";

/** How goals ended, by day, robot or action; every number leads to its goals. */
export default function StatisticsPage() {
  const [parameters, setParameters] = useSearchParams();
  const view = useMemo(() => readView(parameters), [parameters]);
  const { data, error, isPlaceholderData, tooLong, live, refetch, dataUpdatedAt } = useStatistics(view);
  return (
    <Stack gap="md">
      <PageTitle title="Statistics" />
      <Controls view={view} onChange={(next) => setParameters(writeView(next), { replace: true })} />
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
          {data.total.ended === 0 ? <NoGoals /> : <Shown statistics={data} />}
        </Stack>
      )}
    </Stack>
  );
}

function Shown({ statistics }: { statistics: Statistics }) {
  return (
    <>
      <Summary total={statistics.total} />
      <Section title={`By ${GROUPINGS[statistics.by].toLowerCase()}`}>
        <GroupTable statistics={statistics} />
      </Section>
      <Section title="Errors">
        <ErrorTable total={statistics.total} />
      </Section>
    </>
  );
}

function NoGoals() {
  return (
    <Stack gap="xs">
      <Text fw={600}>No goal ended</Text>
      <Text size="sm" c="dimmed">
        Goals that were created in this time are counted here once they have ended. Choose a longer time, or
        all robots, groups and tags, to see others.
      </Text>
    </Stack>
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
