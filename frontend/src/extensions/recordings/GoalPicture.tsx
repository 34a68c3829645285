import { useState } from "react";
import classes from "./recordings.module.css";
import { thumbnailUrl } from "./requests";

/** What the robot's camera saw last while a goal ran; nothing where its recording has no picture. */
export function GoalPicture({ goalId, small = false }: { goalId: string; small?: boolean }) {
  const [missing, setMissing] = useState(false);
  if (missing) return null;
  return (
    <img
      src={thumbnailUrl(goalId)}
      alt="What the robot's camera saw last"
      title="What the robot's camera saw last"
      loading="lazy"
      className={classes.picture}
      data-small={small || undefined}
      onError={() => setMissing(true)}
    />
  );
}
