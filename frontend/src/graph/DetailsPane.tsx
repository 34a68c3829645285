import { Alert, Anchor, CloseButton, Drawer, Group, Kbd, Paper, Stack, Text, Title } from "@mantine/core";
import { useMediaQuery } from "@mantine/hooks";
import type { ReactNode } from "react";
import { Link } from "react-router";
import type { Graph, GraphAction, GraphNode, GraphService } from "../api/graph";
import { apiAddress } from "../api/site";
import { Command, CopyButton } from "../ui/CopyButton";
import { ServiceCall } from "./calls";
import { clientsOf } from "./filter";
import classes from "./graph.module.css";
import { NodeParameters } from "./NodeParameters";
import { ThingList, TypeNames } from "./names";
import { TopicDetails } from "./TopicDetails";
import type { Thing } from "./things";
import type { ChangeView, GraphView } from "./view";

interface DetailsPaneProps {
  graph: Graph;
  view: GraphView;
  change: ChangeView;
}

/** All about the selected thing: next to the graph, or over it where there is no room. */
export function DetailsPane({ graph, view, change }: DetailsPaneProps) {
  const { selected, echo } = view;
  const beside = useMediaQuery("(min-width: 75em)", true, { getInitialValueInEffect: false });
  const close = () => change({ selected: null });
  const details = selected !== null && <Details graph={graph} thing={selected} echo={echo} change={change} />;

  if (beside) {
    return (
      <Paper component="aside" withBorder radius="md" p="md" className={classes.pane} aria-label="Details">
        {selected === null ? (
          <Hint />
        ) : (
          <>
            <Head thing={selected} onClose={close} />
            {details}
          </>
        )}
      </Paper>
    );
  }
  return (
    <Drawer.Root opened={selected !== null} onClose={close} position="right" size="lg">
      <Drawer.Overlay className={classes.belowHeader} />
      <Drawer.Content
        aria-label="Details"
        classNames={{ inner: classes.belowHeader, content: classes.drawer }}
      >
        <Drawer.Body pt="md">
          {selected !== null && <Head thing={selected} onClose={close} />}
          {details}
        </Drawer.Body>
      </Drawer.Content>
    </Drawer.Root>
  );
}

function Hint() {
  return (
    <Stack gap="sm" c="dimmed">
      <Text size="sm">
        Choose a node, a topic or an action to see its types, its quality of service and who is at it; of a
        topic also the messages, as they come.
      </Text>
      <Text size="sm" component="div">
        In the picture: <Kbd>←</Kbd> <Kbd>↑</Kbd> <Kbd>→</Kbd> <Kbd>↓</Kbd> go to the next thing,{" "}
        <Kbd>Enter</Kbd> chooses it, <Kbd>+</Kbd> <Kbd>−</Kbd> <Kbd>0</Kbd> bring it closer, farther, and all
        of it into sight. The mouse drags things, and the wheel zooms with <Kbd>Ctrl</Kbd>.
      </Text>
      <Command line={`curl ${apiAddress()}/graph`} what="the command that reads the graph" />
    </Stack>
  );
}

function Head({ thing: { kind, name }, onClose }: { thing: Thing; onClose: () => void }) {
  return (
    <Stack gap={4} mb="md">
      <Group justify="space-between" wrap="nowrap">
        <Text size="sm" c="dimmed" tt="capitalize">
          {kind}
        </Text>
        <Group gap="xs" wrap="nowrap">
          <CopyButton value={name} what="the name" />
          <CloseButton aria-label="Close the details" onClick={onClose} />
        </Group>
      </Group>
      <Title order={2} size="h4" className={classes.wrap} data-testid="selected">
        {name}
      </Title>
    </Stack>
  );
}

interface DetailsProps {
  graph: Graph;
  thing: Thing;
  echo: boolean;
  change: ChangeView;
}

function Details({ graph, thing: { kind, name }, echo, change }: DetailsProps): ReactNode {
  const named = (thing: { name: string }) => thing.name === name;
  switch (kind) {
    case "node": {
      const node = graph.nodes.find(named);
      return node ? <NodeDetails node={node} change={change} /> : <Gone />;
    }
    case "topic": {
      const topic = graph.topics.find(named);
      return topic ? <TopicDetails key={name} topic={topic} echo={echo} change={change} /> : <Gone />;
    }
    case "action": {
      const action = graph.actions.find(named);
      return action ? <ActionDetails action={action} change={change} /> : <Gone />;
    }
    case "service": {
      const service = graph.services.find(named);
      return service ? <ServiceDetails service={service} nodes={graph.nodes} change={change} /> : <Gone />;
    }
  }
}

function Gone() {
  return (
    <Text size="sm" role="status">
      It is not on the graph now. It shows up here by itself when it is back.
    </Text>
  );
}

/** What a node publishes, hears, offers and asks for. */
function NodeDetails({ node, change }: { node: GraphNode; change: ChangeView }) {
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
      <NodeParameters key={node.name} node={node.name} />
      <Command line={`ros2 node info ${node.name}`} what="the command for a terminal" />
    </Stack>
  );
}

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
function ServedDetails(props: ServedDetailsProps) {
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
function ActionDetails({ action, change }: { action: GraphAction; change: ChangeView }) {
  const { name, types, servers, clients } = action;
  return (
    <ServedDetails
      types={types}
      servers={servers}
      unserved="None: goals are not answered."
      clients={clients}
      line={`curl ${apiAddress()}/actions${name}`}
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
function ServiceDetails({ service, nodes, change }: ServiceDetailsProps) {
  const { name, types, servers } = service;
  return (
    <ServedDetails
      types={types}
      servers={servers}
      unserved="None: calls wait."
      clients={clientsOf(nodes).get(name) ?? []}
      line={`ros2 service call ${name} ${types[0] ?? ""}`}
      change={change}
    >
      {servers.length > 0 && <ServiceCall key={name} service={service} />}
    </ServedDetails>
  );
}
