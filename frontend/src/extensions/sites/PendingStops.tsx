import { Group, Paper, Text } from "@mantine/core";
import { Release } from "../../stop/StopBanner";
import { Time } from "../../ui/Time";
import { useSites } from "./sites";

/** On every page of a hub: the stops that a site has not confirmed, which the hub sends again until it is released. */
export default function PendingStops() {
  const { data: sites = [] } = useSites();
  return sites.map(({ name, stop: { pending } }) => {
    if (pending == null) return null;
    const { robots, by, stopped_at: since } = pending;
    const held = { robot: `/${name}`, since, by, holds: robots, persisted: true };
    return (
      <Paper
        key={name}
        component="section"
        aria-label={`Stop of ${name}`}
        withBorder
        radius="md"
        p="md"
        bd="2px solid red"
        data-testid="pending-stop"
      >
        <Group justify="space-between" gap="md">
          <div role="status" style={{ flex: "1 1 20rem" }}>
            <Text fw={700} fz="lg">
              Stop has NOT reached {name}
            </Text>
            <Text size="sm">
              {robots.join(", ")}: stopped{by !== null && ` by ${by}`} at <Time value={since} />. The hub
              repeats it until the site confirms it. Use the robots' own emergency stops if they move.
            </Text>
          </div>
          <Release held={[held]} />
        </Group>
      </Paper>
    );
  });
}
