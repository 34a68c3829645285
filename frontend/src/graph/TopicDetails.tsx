import { Alert, Stack, Text } from "@mantine/core";
import { useMemo } from "react";
import { Command } from "../ui/Command";
import { Echo } from "./Echo";
import { EndpointList } from "./EndpointList";
import { conflictsOf } from "./qos";
import { TypeNames } from "./TypeNames";
import type { GraphTopic } from "./types";
import type { ChangeView } from "./useView";

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
      <EndpointList
        title="Publishers"
        absent="Nobody publishes."
        endpoints={publishers}
        conflicting={conflicts.map(({ publisher }) => publisher)}
        change={change}
      />
      <EndpointList
        title="Subscribers"
        absent="Nobody listens."
        endpoints={subscribers}
        conflicting={conflicts.map(({ subscriber }) => subscriber)}
        change={change}
      />
      <Command line={`ros2 topic info -v ${name}`} what="the command for a terminal" />
    </Stack>
  );
}
