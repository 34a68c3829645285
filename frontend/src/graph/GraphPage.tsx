import type { ClientError } from "@dock-gateway/client";
import { Code, Group, Paper, SegmentedControl, Skeleton, Stack, Text } from "@mantine/core";
import { useMediaQuery } from "@mantine/hooks";
import { type UseQueryResult, useQuery, useQueryClient } from "@tanstack/react-query";
import { Suspense, useDeferredValue, useMemo } from "react";
import { type Graph, gatewayNode, readGraph, type TaggedGraph } from "../api/graph";
import { apiAddress } from "../api/site";
import { useFleet } from "../fleet/context";
import { useAddress } from "../ui/address";
import { Command } from "../ui/CopyButton";
import { CommandErrorAlert } from "../ui/errors";
import { lazyPart } from "../ui/lazyPart";
import { useAnswer } from "../ui/requests";
import { Heading, usePageTitle } from "../ui/Section";
import { DetailsPane } from "./DetailsPane";
import { filterGraph, searchGraph } from "./filter";
import { GraphFilters } from "./GraphFilters";
import { GraphList } from "./GraphList";
import classes from "./graph.module.css";
import { baseName } from "./things";
import { type ChangeView, type Form, type GraphView, graphView } from "./view";
import { describeShown } from "./words";

const GraphPicture = lazyPart(() => import("./GraphPicture"));

const FORMS: { value: Form; label: string }[] = [
  { value: "picture", label: "Picture" },
  { value: "list", label: "List" },
];

/** Nodes, topics and actions on the ROS graph, in a picture or in a list, and what there is to know of each. */
export default function GraphPage() {
  const [view, change] = useAddress(graphView, "selected");
  const narrow = useMediaQuery("(max-width: 48em)", false, { getInitialValueInEffect: false });
  const { data: graph, error, refetch } = useGraph();
  const form = view.form ?? (narrow ? "list" : "picture");
  usePageTitle(view.selected === null ? "Graph" : `${baseName(view.selected.name)} · Graph`);

  return (
    <Stack gap="sm" className={classes.wide}>
      <Group justify="space-between" gap="xs">
        <Heading order={1} title="Graph" help="graph" />
        <SegmentedControl
          aria-label="Show the graph as"
          data={FORMS}
          value={form}
          onChange={(value) => change({ form: value === "list" ? "list" : "picture" })}
        />
      </Group>
      {graph === undefined && error !== null && (
        <CommandErrorAlert command="Reading the graph" error={error} onClose={() => void refetch()} />
      )}
      <GraphFilters graph={graph} form={form} view={view} change={change} />
      {graph === undefined ? (
        <div className={classes.columns} aria-busy="true">
          <Skeleton className={classes.picture} />
          <Skeleton className={classes.picture} visibleFrom="lg" />
        </div>
      ) : (
        <Shown graph={graph} form={form} view={view} change={change} />
      )}
    </Stack>
  );
}

interface ShownProps {
  graph: Graph;
  form: Form;
  view: GraphView;
  change: ChangeView;
}

function Shown({ graph, form, view, change }: ShownProps) {
  // A pressed control shows it before the whole picture is drawn again.
  const { namespace, hidden, services, gateway, search, shown } = useDeferredValue(view);
  const gatewayNode = useGatewayNode();
  const filtered = useMemo(
    () => filterGraph(graph, { namespace, hidden, services, gateway, gatewayNode }),
    [graph, namespace, hidden, services, gateway, gatewayNode],
  );
  const found = useMemo(() => searchGraph(filtered, search), [filtered, search]);
  const matching = found.nodes.length + found.topics.length + found.services.length + found.actions.length;
  const empty = filtered.nodes.length + filtered.topics.length + filtered.actions.length === 0;

  return (
    <>
      <Text size="sm" c="dimmed" role="status" className="tabular" data-testid="graph-count">
        {describeShown(filtered, graph)}
        {search.trim() !== "" &&
          `; ${matching === 0 ? "nothing matches" : `${matching} match`} “${search.trim()}”`}
      </Text>
      <div className={classes.columns}>
        {empty ? (
          <EmptyGraph filtered={namespace !== "/"} />
        ) : form === "list" ? (
          <GraphList graph={found} nodes={graph.nodes} selected={view.selected} change={change} />
        ) : (
          <Suspense fallback={<Skeleton className={classes.picture} />}>
            <GraphPicture
              graph={filtered}
              found={found}
              shown={shown}
              arrangement={[shown, namespace, hidden, services, gateway].join(" ")}
              selected={view.selected}
              change={change}
            />
          </Suspense>
        )}
        <DetailsPane graph={graph} view={view} change={change} />
      </div>
    </>
  );
}

/** What to do where there is nothing to show. */
function EmptyGraph({ filtered }: { filtered: boolean }) {
  return (
    <Paper withBorder radius="md" p="lg">
      <Stack gap="sm">
        <Text fw={600}>Nothing to show</Text>
        <Text size="sm" c="dimmed">
          {filtered
            ? "Nothing on the graph is in this namespace. Choose another one above."
            : "The gateway is alone on the ROS graph, as far as it sees. Nodes show up here within seconds of their start, if they have the same ROS_DOMAIN_ID."}
        </Text>
        <Text size="sm">
          A simulated robot: <Code>dock-gateway up</Code>. The same as this page, in a terminal:
        </Text>
        <Command line={`curl ${apiAddress()}/graph`} what="the command that reads the graph" />
      </Stack>
    </Paper>
  );
}

const INTERVAL_MS = 2000;
const KEY = ["graph"];

/** The ROS graph, asked for every two seconds while the page is looked at; the same object until it changes. */
function useGraph(): UseQueryResult<Graph, ClientError> {
  const { http } = useFleet();
  const client = useQueryClient();
  return useAnswer({
    queryKey: KEY,
    queryFn: () => readGraph(http, client.getQueryData<TaggedGraph>(KEY)),
    select: graphOf,
    refetchInterval: INTERVAL_MS,
  });
}

function graphOf({ graph }: TaggedGraph): Graph {
  return graph;
}

/** The gateway's node: its default name until the gateway has answered. */
function useGatewayNode(): string {
  const { http } = useFleet();
  const { data } = useQuery({
    queryKey: ["gateway-node"],
    queryFn: () => gatewayNode(http),
    staleTime: Number.POSITIVE_INFINITY,
  });
  return data ?? "/dock_gateway";
}
