import { Badge, VisuallyHidden } from "@mantine/core";
import type { Freshness } from "../store/freshness";

const LOOKS: Record<Exclude<Freshness, "live">, { words: string; color: string }> = {
  stale: { words: "Stale", color: "orange" },
  none: { words: "No data", color: "gray.7" },
  offline: { words: "Not live", color: "gray.7" },
};

/** How current what is beside it is. That it is live, as it should be, is said to screen readers alone. */
export function FreshnessBadge({ freshness }: { freshness: Freshness }) {
  if (freshness === "live") return <VisuallyHidden>Live</VisuallyHidden>;
  const { words, color } = LOOKS[freshness];
  return <Badge color={color}>{words}</Badge>;
}
