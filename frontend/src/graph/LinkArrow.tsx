import { BaseEdge, type EdgeProps, getBezierPath } from "@xyflow/react";
import { memo } from "react";
import { levelPath } from "./curve";
import type { LinkEdge } from "./flow";

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
