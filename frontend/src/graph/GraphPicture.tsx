import "@xyflow/react/dist/base.css";
import { Button, Group, Stack, Text, useComputedColorScheme } from "@mantine/core";
import { type NodeChange, Panel, ReactFlow, ReactFlowProvider, useReactFlow } from "@xyflow/react";
import { type KeyboardEvent, useCallback, useEffect, useMemo, useRef, useState } from "react";
import type { Graph } from "../api/graph";
import { Tool } from "../ui/Tool";
import { type Elements, elementsOf, type Vertex } from "./elements";
import { flowEdges, flowNodes, type LinkEdge, type VertexNode } from "./flow";
import classes from "./graph.module.css";
import { directionOf, type Place, stepFrom } from "./layout";
import { parseThing, type Thing, thingId } from "./things";
import { usePlaces, useSight } from "./usePlaces";
import { LinkArrow, VertexBox } from "./VertexBox";
import type { ChangeView, Shown } from "./view";

/** More things than this take seconds to lay out, and are too small to read. */
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

const NODE_TYPES = { vertex: VertexBox };
const EDGE_TYPES = { link: LinkArrow };
const FIT = { padding: 0.06, maxZoom: 1 } as const;

interface FlowPictureProps {
  elements: Elements;
  /** All is arranged again when this changes. */
  arrangement: string;
  /** The ids that the search has found; null without a search. */
  matching: ReadonlySet<string> | null;
  selected: string | null;
  onSelect: (selected: Thing | null) => void;
}

/** The picture, to be moved by mouse, fingers and keys. */
function FlowPicture({ elements, arrangement, matching, selected, onSelect }: FlowPictureProps) {
  const scheme = useComputedColorScheme("light");
  const frame = useRef<HTMLDivElement>(null);
  const flow = useReactFlow<VertexNode, LinkEdge>();
  const { places, routes, times, move, rearrange } = usePlaces(elements, arrangement);
  const [walked, setWalked] = useState<string | null>(null);
  const tabStop =
    [walked, selected].find((id) => id !== null && places.has(id)) ?? elements.vertices[0]?.id ?? null;
  const select = useCallback(
    (vertex: Vertex) => {
      setWalked(vertex.id);
      onSelect(parseThing(vertex.id));
    },
    [onSelect],
  );
  const nodes = useMemo(
    () => flowNodes(elements, places, { matching, selected, tabStop }, select),
    [elements, places, matching, selected, tabStop, select],
  );
  const edges = useMemo(
    () => flowEdges(elements, { places, routes }, { selected }),
    [elements, places, routes, selected],
  );
  const { show, ensureInSight, leave } = useSight(frame, FIT);
  const zoom = (change: "zoomIn" | "zoomOut") => {
    leave();
    void flow[change]();
  };

  // biome-ignore lint/correctness/useExhaustiveDependencies: another layout is shown whole
  useEffect(() => show(null), [show, times]);
  useEffect(() => {
    if (matching !== null && matching.size > 0) show(matching);
  }, [show, matching]);
  useEffect(() => {
    if (selected !== null) ensureInSight(selected);
  }, [ensureInSight, selected]);

  const onNodesChange = (changes: NodeChange<VertexNode>[]) => {
    const moved = new Map<string, Place>();
    for (const change of changes) {
      if (change.type === "position" && change.position !== undefined) moved.set(change.id, change.position);
    }
    if (moved.size > 0) move(moved);
  };

  const onKeyDown = (event: KeyboardEvent) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const way = directionOf(event.key);
    const act =
      way !== null
        ? () => walk(stepFrom(places, tabStop ?? "", way))
        : { "+": () => zoom("zoomIn"), "-": () => zoom("zoomOut"), "0": () => show(null) }[event.key];
    if (act === undefined) return;
    event.preventDefault();
    act();
  };

  const walk = (id: string | null) => {
    if (id === null) return;
    setWalked(id);
    ensureInSight(id);
    const next = frame.current?.querySelector(`[data-id="${CSS.escape(id)}"] button`);
    if (next instanceof HTMLElement) next.focus({ preventScroll: true });
  };

  return (
    // biome-ignore lint/a11y/noStaticElementInteractions: the keys are those of the buttons in it
    <div ref={frame} className={classes.picture} data-testid="graph-picture" onKeyDown={onKeyDown}>
      <ReactFlow
        nodes={nodes}
        edges={edges}
        nodeTypes={NODE_TYPES}
        edgeTypes={EDGE_TYPES}
        onNodesChange={onNodesChange}
        onMoveStart={(event) => event !== null && leave()}
        colorMode={scheme}
        className={classes.flow ?? ""}
        minZoom={0.05}
        maxZoom={2.5}
        fitView
        fitViewOptions={FIT}
        nodesConnectable={false}
        nodesFocusable={false}
        edgesFocusable={false}
        elementsSelectable={false}
        selectNodesOnDrag={false}
        nodeDragThreshold={4}
        // The wheel alone scrolls the page; with Ctrl, as a pinch on a trackpad sends it, it zooms.
        zoomOnScroll={false}
        zoomOnDoubleClick={false}
        preventScrolling={false}
        disableKeyboardA11y
        deleteKeyCode={null}
        selectionKeyCode={null}
        multiSelectionKeyCode={null}
        panActivationKeyCode={null}
        zoomActivationKeyCode={null}
        defaultMarkerColor={null}
      >
        <Panel position="top-right">
          <Group gap={4}>
            <Tool name="Closer (+)" path="M11 5h2v6h6v2h-6v6h-2v-6H5v-2h6z" onClick={() => zoom("zoomIn")} />
            <Tool name="Farther (−)" path="M5 11h14v2H5z" onClick={() => zoom("zoomOut")} />
            <Tool
              name="All of it (0)"
              path="M4 4h6v2H6v4H4zm10 0h6v6h-2V6h-4zM4 14h2v4h4v2H4zm14 0h2v6h-6v-2h4z"
              onClick={() => show(null)}
            />
            <Tool
              name="Re-arrange"
              path="M3 4h6v5H7v2h10V9h-2V4h6v5h-2v4h-6v2h2v5H9v-5h2v-2H5V9H3z"
              onClick={rearrange}
            />
          </Group>
        </Panel>
      </ReactFlow>
    </div>
  );
}
