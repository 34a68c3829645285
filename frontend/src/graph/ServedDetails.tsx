import { Anchor, Stack } from "@mantine/core";
import type { ReactNode } from "react";
import { Link } from "react-router";
import type { GraphAction, GraphNode, GraphService } from "../api/graph";
import { Command } from "../ui/CopyButton";
import { clientsOf } from "./filter";
import { ThingList, TypeNames } from "./names";
import type { ChangeView } from "./view";

interface ServedDetailsProps {
  types: readonly string[];
  servers: readonly string[];
  /** What it means that there are none. */
  unserved: string;
  clients: readonly string[];
  /** How it is used from a terminal. */
  line: string;
  change: ChangeView;
  /** The ways on. */
  children?: ReactNode;
}

/** Who serves something, and who asks for it: a service or an action. */
export function ServedDetails(props: ServedDetailsProps) {
  const { types, servers, unserved, clients, line, change, children } = props;
  return (
    <Stack gap="md">
      <TypeNames types={types} />
      <ThingList title="Servers" kind="node" names={servers} absent={unserved} change={change} />
      <ThingList title="Clients" kind="node" names={clients} absent="None." change={change} />
      {children}
      <Command line={line} what="the command for a terminal" />
    </Stack>
  );
}

/** Who serves an action, who sends goals to it, and the ways on. */
export function ActionDetails({ action, change }: { action: GraphAction; change: ChangeView }) {
  const { name, types, servers, clients } = action;
  return (
    <ServedDetails
      types={types}
      servers={servers}
      unserved="None: goals are not answered."
      clients={clients}
      line={`curl ${window.location.origin}/actions${name}`}
      change={change}
    >
      <Stack gap={4}>
        <Anchor component={Link} to={`/ui/actions${name}`} size="sm">
          Send a goal
        </Anchor>
        <Anchor component={Link} to={`/ui/goals?${new URLSearchParams({ action: name })}`} size="sm">
          Its goals
        </Anchor>
      </Stack>
    </ServedDetails>
  );
}

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
      unserved="None: calls wait."
      clients={clientsOf(nodes).get(name) ?? []}
      line={`ros2 service call ${name} ${types[0] ?? ""}`}
      change={change}
    />
  );
}
