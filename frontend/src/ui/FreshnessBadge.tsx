import { Badge } from "@mantine/core";
import type { Freshness } from "../store/freshness";

const LOOKS: Record<Freshness, { words: string; color: string }> = {
  live: { words: "Live", color: "green" },
  stale: { words: "Stale", color: "orange" },
  none: { words: "No data", color: "gray.7" },
  offline: { words: "Not live", color: "gray.7" },
};

/** How current what is beside it is. */
export function FreshnessBadge({ freshness }: { freshness: Freshness }) {
  const { words, color } = LOOKS[freshness];
  return <Badge color={color}>{words}</Badge>;
}
