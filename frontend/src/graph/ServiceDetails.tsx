import { Stack } from "@mantine/core";
import { Command } from "../ui/Command";
import { clientsOf } from "./filter";
import { ThingList } from "./ThingList";
import { TypeNames } from "./TypeNames";
import type { GraphNode, GraphService } from "./types";
import type { ChangeView } from "./useView";

interface ServiceDetailsProps {
  service: GraphService;
  nodes: readonly GraphNode[];
  change: ChangeView;
}

/** Who offers a service, and who asks. */
export function ServiceDetails({ service: { name, types, servers }, nodes, change }: ServiceDetailsProps) {
  return (
    <Stack gap="md">
      <TypeNames types={types} />
      <ThingList
        title="Servers"
        kind="node"
        names={servers}
        absent="Nobody: who calls it waits."
        change={change}
      />
      <ThingList
        title="Clients"
        kind="node"
        names={clientsOf(nodes).get(name) ?? []}
        absent="Nobody."
        change={change}
      />
      <Command line={`ros2 service call ${name} ${types[0] ?? ""}`} what="the command for a terminal" />
    </Stack>
  );
}
