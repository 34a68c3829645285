import { Badge, VisuallyHidden } from "@mantine/core";
import { memo } from "react";
import type { Freshness } from "../store/context";
import classes from "./fleet.module.css";
import { LINK_WORDS, type Link, linkHint } from "./words";

const LOOKS: Record<Exclude<Freshness, "live">, { words: string; color: string }> = {
  stale: { words: "Stale", color: "orange" },
  none: { words: "No data", color: "gray.7" },
  offline: { words: "Not live", color: "gray.7" },
};

/** How current the values next to it are. If they are live, only screen readers say so. */
export function FreshnessBadge({ freshness }: { freshness: Freshness }) {
  if (freshness === "live") return <VisuallyHidden>Live</VisuallyHidden>;
  const { words, color } = LOOKS[freshness];
  return <Badge color={color}>{words}</Badge>;
}

/** Whether a robot can be reached, in words. */
export const LinkState = memo(function LinkState({ link, live }: { link: Link; live: boolean }) {
  return (
    <span
      className={classes.link}
      data-link={live ? link : "unknown"}
      title={live ? linkHint(link) : undefined}
    >
      {live ? LINK_WORDS[link] : "Not live"}
    </span>
  );
});
