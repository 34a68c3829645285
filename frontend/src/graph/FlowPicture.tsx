import { useComputedColorScheme } from "@mantine/core";
import { type NodeChange, Panel, ReactFlow, useReactFlow } from "@xyflow/react";
import { type KeyboardEvent, useCallback, useEffect, useMemo, useRef, useState } from "react";
import type { Elements, Vertex } from "./elements";
import { flowEdges, flowNodes, type LinkEdge, type VertexNode } from "./flow";
import classes from "./graph.module.css";
import { LinkArrow } from "./LinkArrow";
import type { Place } from "./layout";
import { PictureButtons } from "./PictureButtons";
import { directionOf, stepFrom } from "./steps";
import { parseThing, type Thing } from "./things";
import { usePlaces } from "./usePlaces";
import { useSight } from "./useSight";
import { VertexBox } from "./VertexBox";

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
export function FlowPicture({ elements, arrangement, matching, selected, onSelect }: FlowPictureProps) {
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
          <PictureButtons
            onIn={() => zoom("zoomIn")}
            onOut={() => zoom("zoomOut")}
            onFit={() => show(null)}
            onRearrange={rearrange}
          />
        </Panel>
      </ReactFlow>
    </div>
  );
}
