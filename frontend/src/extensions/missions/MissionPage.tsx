import { Anchor, Group, Skeleton, Stack, Text } from "@mantine/core";
import { Link, useNavigate, useParams } from "react-router";
import { useForbidden } from "../../api/session";
import { useNaming, useWhyNot } from "../../fleet/context";
import { robotPath } from "../../fleet/names";
import { Trouble } from "../../ui/errors";
import { ReasonButton } from "../../ui/ReasonButton";
import { PageTitle, Section } from "../../ui/Section";
import { useFreshMissions } from "./freshMissions";
import { againPath, EditLink, MissionCard } from "./MissionCard";
import { useMission } from "./missions";
import { hasEnded, PRIORITY } from "./queue";
import type { Mission } from "./requests";
import { missionName, takerWords } from "./words";

/** One mission, by the id in the address: its steps, their tries, goals and errors. */
export default function MissionPage() {
  const { missionId = "" } = useParams();
  useFreshMissions();
  const { data: mission, error, refetch } = useMission(missionId);
  return (
    <Stack gap="md">
      <div>
        <Anchor component={Link} to="/ui/missions" size="sm">
          All missions
        </Anchor>
        <PageTitle title={mission === undefined ? "Mission" : missionName(mission)}>
          {mission !== undefined &&
            (hasEnded(mission) ? <Again mission={mission} /> : <EditLink mission={mission} />)}
        </PageTitle>
      </div>
      <Trouble what="The mission could not be loaded" error={error} onRetry={() => void refetch()} />
      {mission === undefined ? (
        error === null && <Skeleton height={220} role="status" aria-label="The mission is loading" />
      ) : (
        <Details mission={mission} />
      )}
    </Stack>
  );
}

function Details({ mission }: { mission: Mission }) {
  const naming = useNaming();
  const name = takerWords(mission, naming);
  const { robot, group } = mission;
  return (
    <Section
      title={name}
      aside={
        <Group gap="sm">
          {mission.priority !== PRIORITY && <Text size="sm">Priority {mission.priority}</Text>}
          {robot !== null && group !== null && <Text size="sm">For any of {group}</Text>}
          {robot !== null && (
            <Anchor component={Link} to={robotPath(robot)} size="sm">
              Go to {name}
            </Anchor>
          )}
        </Group>
      }
    >
      <MissionCard mission={mission} />
    </Section>
  );
}

function Again({ mission }: { mission: Mission }) {
  const forbidden = useForbidden("POST /missions");
  const reason = useWhyNot("POST /missions");
  const navigate = useNavigate();
  if (forbidden !== null) return null;
  return (
    <ReasonButton reason={reason} onClick={() => navigate(againPath(mission))}>
      Run again
    </ReasonButton>
  );
}
