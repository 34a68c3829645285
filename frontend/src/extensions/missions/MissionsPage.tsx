import { Anchor, Button, Group, Skeleton, Stack, Table, Text, VisuallyHidden } from "@mantine/core";
import { Link, useNavigate } from "react-router";
import { useForbidden } from "../../api/session";
import { useFleetLive, useFleetPart, useFleetTopic, useNaming, useWhyNot } from "../../fleet/context";
import { robotPath } from "../../fleet/names";
import { isThere } from "../../fleet/words";
import { Empty } from "../../ui/Empty";
import { Trouble } from "../../ui/errors";
import { ENTRY_BUTTON, ReasonButton } from "../../ui/ReasonButton";
import { PageTitle, Section } from "../../ui/Section";
import { Time } from "../../ui/Time";
import { useZone } from "../../ui/zone";
import { useFreshMissions } from "./freshMissions";
import { againPath, MissionBadge, MissionCard, missionPath } from "./MissionCard";
import { useEndedMissions } from "./missions";
import classes from "./missions.module.css";
import { useOpenMissions } from "./openMissions";
import { QueueList } from "./QueueList";
import { groupQueuesOf, type Queue, queuesOf } from "./queue";
import type { Mission } from "./requests";
import { MissionPages } from "./StoredPage";
import { errorWords, missionName, stepWords, takerWords, tookWords } from "./words";

/** What each robot does and will do, and the missions that have ended. */
export default function MissionsPage() {
  useFreshMissions();
  const forbidden = useForbidden("POST /missions");
  const reason = useWhyNot("POST /missions");
  const navigate = useNavigate();
  const { data: open, error, refetch } = useOpenMissions();
  const ended = useEndedMissions();
  const past = ended.pages?.flatMap(({ missions }) => missions);
  const nothing = open?.length === 0 && past?.length === 0;
  return (
    <Stack gap="md">
      <PageTitle title="Missions" help="extensions/missions#on-the-dashboard">
        {forbidden === null && (
          <ReasonButton reason={reason} onClick={() => navigate("/ui/missions/new")}>
            New mission
          </ReasonButton>
        )}
      </PageTitle>
      <MissionPages />
      <Trouble what="The missions could not be loaded" error={error} onRetry={() => void refetch()} />
      {open === undefined ? (
        error === null && <Loading />
      ) : nothing ? (
        <NoMissions />
      ) : (
        <Queues missions={open} />
      )}
      {past !== undefined && past.length > 0 && (
        <Section title="Ended missions" aside={<Live />}>
          <EndedTable missions={past} />
          {ended.more && (
            <Button variant="default" disabled={ended.loading} onClick={ended.loadMore}>
              Load older missions
            </Button>
          )}
        </Section>
      )}
      <Trouble what="Ended missions could not be loaded" error={ended.error} onRetry={ended.refetch} />
    </Stack>
  );
}

function Live() {
  return (
    <Text size="sm" c="dimmed" role="status">
      {useFleetLive() ? "Live" : "Not live"}
    </Text>
  );
}

function Loading() {
  return (
    <Stack gap="sm" role="status" aria-busy="true" aria-label="The missions are loading">
      <Skeleton height={180} />
      <Skeleton height={120} />
    </Stack>
  );
}

function NoMissions() {
  const forbidden = useForbidden("POST /missions");
  const reason = useWhyNot("POST /missions");
  const navigate = useNavigate();
  return (
    <Empty
      title="No missions"
      examples={
        forbidden === null && (
          <ReasonButton
            variant="default"
            reason={reason}
            onClick={() => navigate("/ui/missions/new?example=charge")}
          >
            Example: dock, wait for 80 %, undock
          </ReasonButton>
        )
      }
    >
      A mission is a list of steps that a robot takes one after the other: it docks, charges to 80 %, undocks
      and drives on. A robot is on one mission at a time; the others wait in its queue. A stop holds a mission
      until someone continues it. A restart of the gateway loses none.
    </Empty>
  );
}

/** The robots that have missions, and those that have none. */
function Queues({ missions }: { missions: readonly Mission[] }) {
  const naming = useNaming();
  const robots = useFleetTopic("robots");
  const queues = queuesOf(missions).sort((a, b) => naming.compare(a.robot, b.robot));
  const busy = new Set(queues.map(({ robot }) => robot));
  const free = [...robots.values()].flatMap((each) =>
    isThere(each) && !busy.has(each.name) ? [each.name] : [],
  );
  return (
    <>
      {queues.map((queue) => (
        <RobotQueue key={queue.robot} queue={queue} />
      ))}
      {groupQueuesOf(missions).map(({ group, next }) => (
        <Section key={group} title={`Any of ${group}`}>
          <QueueList name={`any of ${group}`} next={next} />
        </Section>
      ))}
      {queues.length === 0 ? (
        <Text size="sm" c="dimmed">
          No robot is on a mission.
        </Text>
      ) : (
        free.length > 0 && (
          <Text size="sm" c="dimmed">
            Not on a mission:{" "}
            {naming
              .inOrder(free)
              .map((name) => naming.nameOf(name))
              .join(", ")}
          </Text>
        )
      )}
    </>
  );
}

/** What a robot is on, and what comes next. */
function RobotQueue({ queue: { robot, active, next } }: { queue: Queue }) {
  const name = useNaming().nameOf(robot);
  return (
    <Section
      title={name}
      aside={
        <Anchor component={Link} to={robotPath(robot)} size="sm">
          Go to {name}
        </Anchor>
      }
    >
      {active !== null && <MissionCard mission={active} linked />}
      {next.length > 0 && (
        <div className={classes.next} data-first={active === null || undefined}>
          <Text size="sm" fw={600} component="h3" m={0}>
            Next
          </Text>
          <QueueList name={name} next={next} />
        </div>
      )}
    </Section>
  );
}

function EndedTable({ missions }: { missions: readonly Mission[] }) {
  const several = useFleetPart("robots", (robots) => robots.size > 1);
  return (
    <Table verticalSpacing="xs" horizontalSpacing={8} className={classes.ended ?? ""}>
      <Table.Thead>
        <Table.Tr>
          <Table.Th>Mission</Table.Th>
          {several && <Table.Th visibleFrom="sm">Robot</Table.Th>}
          <Table.Th>Result</Table.Th>
          <Table.Th visibleFrom="sm">Ended</Table.Th>
          <Table.Th visibleFrom="sm">Took</Table.Th>
          <Table.Th visibleFrom="sm">
            <VisuallyHidden>Run again</VisuallyHidden>
          </Table.Th>
        </Table.Tr>
      </Table.Thead>
      <Table.Tbody>
        {missions.map((mission) => (
          <EndedRow key={mission.mission_id} mission={mission} several={several} />
        ))}
      </Table.Tbody>
    </Table>
  );
}

function EndedRow({ mission, several }: { mission: Mission; several: boolean }) {
  const naming = useNaming();
  const navigate = useNavigate();
  const forbidden = useForbidden("POST /missions");
  const reason = useWhyNot("POST /missions");
  useZone();
  const { name, steps, status, error, finished_at } = mission;
  const own = missionName(mission);
  const robotName = takerWords(mission, naming);
  return (
    <Table.Tr>
      <Table.Td className={classes.name}>
        <Anchor component={Link} to={missionPath(mission)} size="sm" fw={600}>
          {own}
        </Anchor>
        {name !== null && (
          <Text size="xs" c="dimmed">
            {steps.slice(0, 4).map(stepWords).join(", ")}
            {steps.length > 4 && ", …"}
          </Text>
        )}
        <Text size="xs" c="dimmed" hiddenFrom="sm">
          {several && `${robotName}, `}
          {finished_at !== null && <Time value={finished_at} />}
        </Text>
      </Table.Td>
      {several && <Table.Td visibleFrom="sm">{robotName}</Table.Td>}
      <Table.Td>
        <Group gap="xs">
          <MissionBadge status={status} />
          {error !== null && (
            <Text size="sm" title={error.detail}>
              {errorWords(error)}
            </Text>
          )}
        </Group>
      </Table.Td>
      <Table.Td visibleFrom="sm" className={`tabular ${classes.time}`}>
        {finished_at !== null && <Time value={finished_at} />}
      </Table.Td>
      <Table.Td visibleFrom="sm" className={`tabular ${classes.time}`}>
        {tookWords(mission, 0)}
      </Table.Td>
      <Table.Td visibleFrom="sm" className={classes.again ?? ""}>
        {forbidden === null && (
          <ReasonButton
            {...ENTRY_BUTTON}
            reason={reason}
            aria-label={`Run again: ${own}`}
            onClick={() => navigate(againPath(mission))}
          >
            Run again
          </ReasonButton>
        )}
      </Table.Td>
    </Table.Tr>
  );
}
