import { BaseEdge, type EdgeProps, getBezierPath, Handle, type NodeProps, Position } from "@xyflow/react";
import { Fragment, memo } from "react";
import type { LinkEdge, VertexNode } from "./flow";
import classes from "./graph.module.css";
import type { Place } from "./layout";
import { describeVertex, linesOf, placeWords } from "./words";

/** A thing in the picture: its kind in words too, since shape and colour alone say nothing to some. */
export const VertexBox = memo(function VertexBox({ data }: NodeProps<VertexNode>) {
  const { vertex, emphasis, tabStop, onSelect } = data;
  const { kind, name, count, warning } = vertex;
  return (
    <>
      <End type="target" side={Position.Left} />
      <End type="target" side={Position.Right} />
      <button
        type="button"
        className={classes.vertex}
        data-kind={kind}
        data-emphasis={emphasis}
        data-warning={warning !== null || count > 1 || undefined}
        tabIndex={tabStop ? 0 : -1}
        aria-label={describeVertex(vertex)}
        aria-pressed={emphasis === "selected"}
        title={name}
        onClick={() => onSelect(vertex)}
      >
        <span className={classes.where}>{placeWords(vertex)}</span>{" "}
        <span className={classes.base}>
          {linesOf(name).map((line) => (
            <Fragment key={line}>
              {line}
              <wbr />
            </Fragment>
          ))}
        </span>
      </button>
      <End type="source" side={Position.Left} />
      <End type="source" side={Position.Right} />
    </>
  );
});

function End({ type, side }: { type: "source" | "target"; side: Position }) {
  return <Handle id={side} type={type} position={side} className={classes.end} isConnectable={false} />;
}

/** An arrow: along its route around what is between, or a plain curve where nothing is or an end was moved. */
export const LinkArrow = memo(function LinkArrow(props: EdgeProps<LinkEdge>) {
  const { data, label, markerEnd, id, sourceX, sourceY, targetX, targetY } = props;
  const [curve, curveX, curveY] = getBezierPath(props);
  const route = data?.route ?? null;
  // The first and the last are at the boxes.
  const between = route?.points.slice(1, -1) ?? [];
  const plain = between.length === 0 || (between.length === 1 && !label);
  const path = plain
    ? curve
    : levelPath([{ x: sourceX, y: sourceY }, ...between, { x: targetX, y: targetY }]);
  const at = !plain && route ? route.label : { x: curveX, y: curveY };
  return (
    <BaseEdge
      id={id}
      path={path}
      label={label}
      labelX={at.x}
      labelY={at.y}
      labelBgPadding={[3, 1]}
      interactionWidth={0}
      {...(markerEnd === undefined ? {} : { markerEnd })}
    />
  );
});

/** A line through all points that is level at each of them, as an SVG path. */
export function levelPath([first, ...others]: readonly Place[]): string {
  if (first === undefined) return "";
  let from = first;
  const parts = [`M ${from.x} ${from.y}`];
  for (const to of others) {
    const middle = (from.x + to.x) / 2;
    parts.push(`C ${middle} ${from.y} ${middle} ${to.y} ${to.x} ${to.y}`);
    from = to;
  }
  return parts.join(" ");
}
