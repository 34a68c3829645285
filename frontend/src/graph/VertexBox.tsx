import { Handle, type NodeProps, Position } from "@xyflow/react";
import { Fragment, memo } from "react";
import type { VertexNode } from "./flow";
import classes from "./graph.module.css";
import { linesOf, placeWords } from "./size";
import { describeVertex } from "./words";

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
