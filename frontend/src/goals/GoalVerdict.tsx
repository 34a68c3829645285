import { Text } from "@mantine/core";
import type { AnyGoal } from "../api/types";
import { useFleetLive } from "../fleet/context";
import { GoalDuration } from "../goal/GoalDuration";
import { advice, meaning } from "../goal/words";
import { isTerminal } from "../store/goals";
import { sentence } from "../ui/sentence";
import classes from "./goalPage.module.css";

/** First what became of a goal, why, and how long it took; then what to do. */
export function GoalVerdict({ goal }: { goal: AnyGoal }) {
  const { error, status } = goal;
  const hint = advice(goal);
  const live = useFleetLive();
  const ended = isTerminal(status);
  return (
    <div className={classes.verdict} data-tone={toneOf(goal)} data-testid="verdict">
      <Text fz="lg" fw={600}>
        {meaning(goal).replace(/\.$/, "")}
        <Text span inherit fw={400} className="tabular">
          {ended ? ", after " : live ? ", for " : ", "}
          <GoalDuration goal={goal} />
          {!ended && live && " so far"}
        </Text>
      </Text>
      {error !== null && status === "canceled" && <Text size="sm">{sentence(error.detail)}.</Text>}
      {hint !== null && (
        <Text size="sm">
          <strong>What to do:</strong> {hint}
        </Text>
      )}
      {error !== null && status !== "canceled" && (
        <details>
          <summary>Details</summary>
          <Text size="sm">{sentence(error.detail)}</Text>
          <Text size="sm">Code: {error.code}</Text>
        </details>
      )}
    </div>
  );
}

/** Only what needs somebody has a colour. */
function toneOf({ status, stalled, error }: AnyGoal): "bad" | "warn" | undefined {
  if (status === "canceled") return undefined;
  if (status === "lost" || error !== null) return "bad";
  return stalled ? "warn" : undefined;
}
