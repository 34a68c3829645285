import { memo } from "react";
import classes from "./fleet.module.css";
import { LINK_HINTS, LINK_WORDS, type Link } from "./words";

/** Whether a robot can be reached, in words. */
export const LinkState = memo(function LinkState({ link, live }: { link: Link; live: boolean }) {
  return (
    <span
      className={classes.link}
      data-link={live ? link : "unknown"}
      title={live ? LINK_HINTS[link] : undefined}
    >
      {live ? LINK_WORDS[link] : "Not live"}
    </span>
  );
});
