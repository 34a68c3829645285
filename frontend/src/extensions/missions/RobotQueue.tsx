import { Anchor, Group, Stack, Text } from "@mantine/core";
import { Link } from "react-router";
import { Section } from "../../ui/Section";
import { MissionBadge, missionPath } from "./MissionCard";
import classes from "./missions.module.css";
import { queuesOf } from "./queue";
import type { Mission } from "./requests";
import { breakWords, holdOf, missionName, stepPlace, stepWords } from "./words";

/** The mission that a robot is on, and how many wait. */
export default function RobotQueue({ missions }: { missions: readonly Mission[] }) {
  const [queue] = queuesOf(missions);
  if (queue === undefined) return null;
  const { active, next } = queue;
  const step = active?.steps[active.step];
  const hold = active === null ? null : holdOf(active);
  return (
    <Section
      title="Mission"
      help="extensions/missions#the-queue-of-a-robot"
      aside={
        <Anchor component={Link} to="/ui/missions" size="sm">
          All missions
        </Anchor>
      }
    >
      <Stack gap={4}>
        {active !== null && (
          <>
            <Group gap="xs">
              <Anchor component={Link} to={missionPath(active)} fw={600} className={classes.name ?? ""}>
                {missionName(active)}
              </Anchor>
              <span role="status">
                <MissionBadge status={active.status} />
              </span>
            </Group>
            {step !== undefined && (
              <Text size="sm">
                {active.recharge !== null && `${breakWords(active)}, then `}
                {stepPlace(active)}: {stepWords(step)}
              </Text>
            )}
            {hold !== null && (
              <Text size="sm">
                {hold.title}. {hold.words}
              </Text>
            )}
          </>
        )}
        {next.length > 0 && (
          <Text size="sm" c="dimmed">
            {next.length === 1 ? "One mission is next" : `${next.length} missions are next`}
          </Text>
        )}
      </Stack>
    </Section>
  );
}
