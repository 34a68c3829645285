import { Badge, Group, Stack, Text, Title } from "@mantine/core";
import classes from "./graph.module.css";
import { describeQuality } from "./qos";
import { ThingLink } from "./ThingLink";
import type { Endpoint } from "./types";
import type { ChangeView } from "./useView";

interface EndpointListProps {
  title: string;
  absent: string;
  endpoints: readonly Endpoint[];
  /** Those of them that do not fit to all of the other side. */
  conflicting: readonly Endpoint[];
  change: ChangeView;
}

/** Publishers or subscribers of a topic, each with its quality of service. */
export function EndpointList({ title, absent, endpoints, conflicting, change }: EndpointListProps) {
  return (
    <Stack gap={4}>
      <Title order={3} size="h5">
        {title}
      </Title>
      {endpoints.length === 0 && (
        <Text size="sm" c="dimmed">
          {absent}
        </Text>
      )}
      <ul className={classes.names}>
        {endpoints.map((endpoint, index) => (
          // biome-ignore lint/suspicious/noArrayIndexKey: a node can be there twice
          <li key={index}>
            <Group gap="xs">
              {endpoint.node === null ? (
                <Text size="sm">a DDS program that is no ROS node</Text>
              ) : (
                <ThingLink kind="node" name={endpoint.node} change={change} />
              )}
              {conflicting.includes(endpoint) && <Badge color="orange">incompatible</Badge>}
            </Group>
            <Text size="sm" c="dimmed">
              {describeQuality(endpoint.qos)}
            </Text>
          </li>
        ))}
      </ul>
    </Stack>
  );
}
