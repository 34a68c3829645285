import { Alert, Text } from "@mantine/core";
import { sentence } from "../ui/text";
import classes from "./goal.module.css";
import { advice, type Meant, meaning } from "./words";

/** Why a goal stands as it does: an alert where something is wrong, a quiet line otherwise. A cancel is no failure. */
export function GoalExplanation({ goal }: { goal: Meant }) {
  const { error, stalled, status } = goal;
  const hint = advice(goal);
  if (status === "canceled" || (error === null && !stalled && status !== "lost")) {
    return (
      <div>
        <Text size="sm" c="dimmed">
          {meaning(goal)}
          {error !== null && ` ${sentence(error.detail)}.`}
        </Text>
        {hint !== null && (
          <Text size="sm" c="dimmed">
            {hint}
          </Text>
        )}
      </div>
    );
  }
  return (
    <Alert color={stalled ? "orange" : "red"} title={meaning(goal)}>
      {hint !== null && <Text size="sm">{hint}</Text>}
      {error !== null && (
        <details className={classes.details}>
          <summary>Details</summary>
          <Text size="sm">{sentence(error.detail)}</Text>
          <Text size="sm">Code: {error.code}</Text>
        </details>
      )}
    </Alert>
  );
}
