import { Alert, Text } from "@mantine/core";
import { adviceFor } from "../api/errors";
import type { AnyGoal } from "../api/types";
import { sentence } from "../ui/sentence";
import { advice } from "./words";

interface GoalExplanationProps {
  goal: Pick<AnyGoal, "status" | "stalled" | "error">;
  /** What its status means, in a sentence. */
  meaning: string;
}

/** Why a goal stands as it does: an alert where something is wrong, a quiet line otherwise. */
export function GoalExplanation({ goal, meaning }: GoalExplanationProps) {
  const { error, stalled, status } = goal;
  if (error === null && !stalled && status !== "lost") {
    return (
      <Text size="sm" c="dimmed">
        {meaning}
      </Text>
    );
  }
  const hint = advice(goal) ?? (error === null ? null : adviceFor(error.code));
  return (
    <Alert color={status === "canceled" || stalled ? "orange" : "red"} title={meaning}>
      {error !== null && <Text size="sm">{sentence(error.detail)}</Text>}
      {hint !== null && <Text size="sm">{hint}</Text>}
      {error !== null && <Text size="sm">Code: {error.code}</Text>}
    </Alert>
  );
}
