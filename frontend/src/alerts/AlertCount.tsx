import { VisuallyHidden } from "@mantine/core";
import { useFleetTopic } from "../fleet/context";
import classes from "./alerts.module.css";
import { openAlerts } from "./order";

/** How many alerts nobody has acknowledged; nothing where there is none. Said aloud when it changes. */
export function AlertCount() {
  const open = openAlerts(useFleetTopic("alerts"));
  const critical = open.some(({ severity }) => severity === "critical");
  const count = open.length;
  return (
    <span role="status">
      {count > 0 && (
        <span className={classes.count} data-critical={critical || undefined} data-testid="alert-count">
          {count}
          <VisuallyHidden>
            {count === 1 ? " alert" : " alerts"}
            {critical && ", critical"}
          </VisuallyHidden>
        </span>
      )}
    </span>
  );
}
