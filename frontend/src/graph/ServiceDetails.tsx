import { clientsOf } from "./filter";
import { ServedDetails } from "./ServedDetails";
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
    <ServedDetails
      types={types}
      servers={servers}
      unserved="Nobody: who calls it waits."
      clients={clientsOf(nodes).get(name) ?? []}
      line={`ros2 service call ${name} ${types[0] ?? ""}`}
      change={change}
    />
  );
}
