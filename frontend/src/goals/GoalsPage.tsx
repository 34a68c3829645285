import { Button, Group, Skeleton, Stack, Table, Text } from "@mantine/core";
import { goalsExportUrl } from "../api/goals";
import { apiAddress } from "../api/site";
import { useFleet, useFleetLive } from "../fleet/context";
import { useAddress } from "../ui/address";
import { Command } from "../ui/CopyButton";
import { Downloads } from "../ui/Downloads";
import { Empty } from "../ui/Empty";
import { Trouble } from "../ui/errors";
import { SavedViews } from "../ui/SavedViews";
import { PageTitle } from "../ui/Section";
import { type GoalFilter, goalFilter, toQuery } from "./filter";
import { GoalFilters } from "./GoalFilters";
import { GoalsHead, GoalsTable } from "./GoalsTable";
import { type GoalList, useGoalList } from "./useGoalList";

/** The goals on all actions, whoever sent them, as they come; narrowed by what the address says. */
export default function GoalsPage() {
  const { store } = useFleet();
  const [filter, change] = useAddress(goalFilter);
  const list = useGoalList(filter);
  return (
    <>
      <PageTitle title="Goals" help="history#stored-data-and-retention">
        <Group gap="xs">
          <SavedViews page="goals" query={goalFilter.write(filter).toString()} />
          <Downloads
            what="these goals"
            url={(format) => goalsExportUrl(toQuery(filter, store.gatewayNow()), format)}
          />
        </Group>
      </PageTitle>
      <GoalFilters filter={filter} change={change} />
      <Trouble what="The list of goals could not be loaded" error={list.error} onRetry={list.refetch} />
      <Listed list={list} filter={filter} onClear={() => change(goalFilter.initial)} />
    </>
  );
}

interface ListedProps {
  list: GoalList;
  filter: GoalFilter;
  onClear: () => void;
}

function Listed({ list, filter, onClear }: ListedProps) {
  const live = useFleetLive();
  const { goals } = list;
  if (goals === null) return list.error === null ? <ListSkeleton /> : null;
  if (goals.length === 0 && !list.loading)
    return <NoGoals filtered={!goalFilter.isInitial(filter)} onClear={onClear} />;
  return (
    <Stack gap="sm">
      <Text size="sm" c="dimmed" role="status">
        {list.more
          ? `The newest ${goals.length} goals`
          : goals.length === 1
            ? "One goal"
            : `${goals.length} goals`}
        {live ? ", live" : ", not live"}
      </Text>
      <GoalsTable goals={goals} />
      {list.more && (
        <Button variant="default" disabled={list.loading} onClick={list.loadMore}>
          Load older goals
        </Button>
      )}
    </Stack>
  );
}

function NoGoals({ filtered, onClear }: { filtered: boolean; onClear: () => void }) {
  if (filtered) {
    return (
      <Empty
        title="No goal fits"
        examples={
          <Button variant="default" onClick={onClear}>
            Show all goals
          </Button>
        }
      >
        Goals that do appear here as they come.
      </Empty>
    );
  }
  return (
    <Empty
      title="No goals yet"
      examples={<Command line={`curl -X POST ${apiAddress()}/dock`} what="the command that docks" />}
    >
      Every goal on every action of the ROS graph is listed here: those sent from these pages, over HTTP, and
      by other ROS nodes. Send the first one from a robot's page or an action's, or from a terminal:
    </Empty>
  );
}

const ROWS = Array.from({ length: 8 }, (_, index) => index);

function ListSkeleton() {
  return (
    <Stack gap="sm" aria-busy="true" aria-label="The goals are loading">
      <Skeleton height={18} width={120} />
      <Table verticalSpacing="xs" horizontalSpacing={8}>
        <GoalsHead oneRobot={false} />
        <Table.Tbody>
          {ROWS.map((row) => (
            <Table.Tr key={row}>
              <Table.Td colSpan={6}>
                <Skeleton height={30} />
              </Table.Td>
            </Table.Tr>
          ))}
        </Table.Tbody>
      </Table>
    </Stack>
  );
}
