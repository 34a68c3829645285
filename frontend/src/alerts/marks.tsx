import { VisuallyHidden } from "@mantine/core";
import { useFleetTopic } from "../fleet/context";
import classes from "./alerts.module.css";
import { openAlerts, together } from "./order";

export type Mark = "critical" | "warning" | "acknowledged";

const SHAPES: Record<Mark, string> = {
  critical: "M8 2h8l6 6v8l-6 6H8l-6-6V8l6-6Zm3 5v6h2V7h-2Zm0 8v2h2v-2h-2Z",
  warning: "M12 2.5 23 21.5H1L12 2.5Zm-1 7v6h2v-6h-2Zm0 7.5v2h2v-2h-2Z",
  acknowledged:
    "M12 2a10 10 0 1 1 0 20 10 10 0 0 1 0-20Zm-1.2 14.6 6.5-6.5-1.4-1.4-5.1 5.1-2.4-2.4L7 12.8l3.8 3.8Z",
};

/** An octagon, a triangle or a tick: distinct without color, too. The text next to it says what it means. */
export function SeverityMark({ mark }: { mark: Mark }) {
  return (
    <svg
      className={classes.mark}
      data-mark={mark}
      width="20"
      height="20"
      viewBox="0 0 24 24"
      aria-hidden="true"
      fill="currentColor"
      fillRule="evenodd"
    >
      <path d={SHAPES[mark]} />
    </svg>
  );
}

/** The number of unacknowledged alerts; nothing for none. Screen readers say when it changes. */
export function AlertCount() {
  const open = openAlerts(useFleetTopic("alerts"));
  const critical = open.some(({ severity }) => severity === "critical");
  const count = together(open).length;
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
