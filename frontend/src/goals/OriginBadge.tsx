import { Badge } from "@mantine/core";
import type { AnyGoal } from "../api/types";

/** Whether a goal was sent through the gateway, or by someone else. */
export function OriginBadge({ origin }: Pick<AnyGoal, "origin">) {
  return (
    <Badge variant="outline" color={origin === "external" ? "grape" : "blue"}>
      {origin}
    </Badge>
  );
}
