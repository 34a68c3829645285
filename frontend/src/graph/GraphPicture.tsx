import "@xyflow/react/dist/base.css";
import { Button, Stack, Text } from "@mantine/core";
import { ReactFlowProvider } from "@xyflow/react";
import { useCallback, useMemo, useState } from "react";
import type { Graph } from "../api/graph";
import { elementsOf } from "./elements";
import { FlowPicture } from "./FlowPicture";
import classes from "./graph.module.css";
import { type Thing, thingId } from "./things";
import type { ChangeView, Shown } from "./view";

/** More than this takes seconds to lay out, and nobody can read it. */
const TOO_MANY = 400;

interface GraphPictureProps {
  graph: Graph;
  /** What of it the search has found. */
  found: Graph;
  shown: Shown;
  /** All is arranged again when this changes. */
  arrangement: string;
  selected: Thing | null;
  change: ChangeView;
}

/** The graph as rqt_graph draws it. */
export default function GraphPicture(props: GraphPictureProps) {
  const { graph, found, shown, arrangement, selected, change } = props;
  const elements = useMemo(() => elementsOf(graph, shown), [graph, shown]);
  const matching = useMemo(() => (found === graph ? null : idsOf(found)), [found, graph]);
  const select = useCallback((thing: Thing | null) => change({ selected: thing }), [change]);
  const [insists, setInsists] = useState(false);

  if (elements.vertices.length > TOO_MANY && !insists) {
    return (
      <Stack className={classes.picture} align="center" justify="center" p="lg">
        <Text fw={600}>{elements.vertices.length} things are too many to read in one picture</Text>
        <Text size="sm" c="dimmed" ta="center">
          Choose a namespace above, show nodes only, or read the list.
        </Text>
        <Button variant="default" onClick={() => setInsists(true)}>
          Draw it anyway
        </Button>
      </Stack>
    );
  }
  return (
    <ReactFlowProvider>
      <FlowPicture
        elements={elements}
        arrangement={arrangement}
        matching={matching}
        selected={selected && thingId(selected)}
        onSelect={select}
      />
    </ReactFlowProvider>
  );
}

function idsOf({ nodes, topics, services, actions }: Graph): ReadonlySet<string> {
  return new Set([
    ...nodes.map(({ name }) => thingId({ kind: "node", name })),
    ...topics.map(({ name }) => thingId({ kind: "topic", name })),
    ...services.map(({ name }) => thingId({ kind: "service", name })),
    ...actions.map(({ name }) => thingId({ kind: "action", name })),
  ]);
}
