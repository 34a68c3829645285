import { Badge } from "@mantine/core";
import type { AnyGoal } from "../api/types";

const ORIGINS: Record<AnyGoal["origin"], { words: string; color: string }> = {
  gateway: { words: "gateway", color: "blue" },
  automation: { words: "automatic", color: "teal" },
  external: { words: "external", color: "grape" },
};

/** Whether a goal was sent through the gateway, by a rule of automatic docking, or by someone else. */
export function OriginBadge({ origin }: Pick<AnyGoal, "origin">) {
  const { words, color } = ORIGINS[origin];
  return (
    <Badge variant="outline" color={color}>
      {words}
    </Badge>
  );
}
