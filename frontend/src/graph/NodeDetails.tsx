import { Alert, Stack } from "@mantine/core";
import type { GraphNode } from "../api/graph";
import { Command } from "../ui/CopyButton";
import { ThingList } from "./names";
import type { ChangeView } from "./view";

/** What a node publishes, hears, offers and asks for. */
export function NodeDetails({ node, change }: { node: GraphNode; change: ChangeView }) {
  return (
    <Stack gap="md">
      {node.count > 1 && (
        <Alert color="orange" title={`${node.count} nodes have this name`}>
          ROS asks for names that are unique. What is below is that of all of them; give one another name with
          --ros-args -r __node:=name.
        </Alert>
      )}
      <ThingList title="Publishes" kind="topic" names={node.publishers} absent="Nothing." change={change} />
      <ThingList
        title="Subscribes to"
        kind="topic"
        names={node.subscribers}
        absent="Nothing."
        change={change}
      />
      <ThingList title="Serves actions" kind="action" names={node.action_servers} change={change} />
      <ThingList title="Sends goals to" kind="action" names={node.action_clients} change={change} />
      <ThingList title="Serves" kind="service" names={node.services} change={change} />
      <ThingList title="Asks services" kind="service" names={node.clients} change={change} />
      <Command line={`ros2 node info ${node.name}`} what="the command for a terminal" />
    </Stack>
  );
}
