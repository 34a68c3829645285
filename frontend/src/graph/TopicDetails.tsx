import { Alert, Badge, Group, Stack, Text, Title } from "@mantine/core";
import { useMemo } from "react";
import type { Endpoint, GraphTopic } from "../api/graph";
import { Command } from "../ui/CopyButton";
import { TopicPublish } from "./calls";
import { Echo } from "./Echo";
import classes from "./graph.module.css";
import { ThingLink, TypeNames } from "./names";
import { conflictsOf, describeQuality } from "./qos";
import type { ChangeView } from "./view";

interface TopicDetailsProps {
  topic: GraphTopic;
  echo: boolean;
  change: ChangeView;
}

/** A topic's type, its messages, and who publishes and hears them with which quality of service. */
export function TopicDetails({ topic, echo, change }: TopicDetailsProps) {
  const { name, types, publishers, subscribers } = topic;
  const conflicts = useMemo(() => conflictsOf(topic), [topic]);
  return (
    <Stack gap="md">
      <TypeNames types={types} />
      {types.length > 1 && (
        <Alert color="orange" title="More than one type">
          Publishers and subscribers of different types do not hear each other.
        </Alert>
      )}
      {conflicts.length > 0 && (
        <Alert color="orange" title="Messages do not arrive">
          {conflicts.map(({ publisher, subscriber, reasons }, index) => (
            // biome-ignore lint/suspicious/noArrayIndexKey: a node can be there twice
            <Text key={index} size="sm">
              {subscriber.node ?? "A subscriber"} hears nothing of {publisher.node ?? "a publisher"}: it asks
              for {reasons.join("; ")}.
            </Text>
          ))}
        </Alert>
      )}
      <Echo topic={name} on={echo} onSwitch={(on) => change({ echo: on })} />
      <TopicPublish key={name} topic={topic} />
      <EndpointList
        title="Publishers"
        absent="None."
        endpoints={publishers}
        conflicting={conflicts.map(({ publisher }) => publisher)}
        change={change}
      />
      <EndpointList
        title="Subscribers"
        absent="None."
        endpoints={subscribers}
        conflicting={conflicts.map(({ subscriber }) => subscriber)}
        change={change}
      />
      <Command line={`ros2 topic info -v ${name}`} what="the command for a terminal" />
    </Stack>
  );
}

interface EndpointListProps {
  title: string;
  absent: string;
  endpoints: readonly Endpoint[];
  /** The endpoints whose quality of service does not match every endpoint of the other side. */
  conflicting: readonly Endpoint[];
  change: ChangeView;
}

/** Publishers or subscribers of a topic, each with its quality of service. */
function EndpointList({ title, absent, endpoints, conflicting, change }: EndpointListProps) {
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
