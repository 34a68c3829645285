import { Text, VisuallyHidden } from "@mantine/core";
import type { Goal } from "../api/types";
import { useTopic } from "../store/context";
import { useVerbOf } from "../store/verbs";
import classes from "./docking.module.css";
import { type StepState, stepsOf } from "./stages";

const SIGNS: Record<StepState, string> = { done: "✓", current: "", failed: "✕", waiting: "" };
const SAID: Record<StepState, string> = {
  done: "done",
  current: "now",
  failed: "did not work",
  waiting: "not yet",
};

/** The stages of a goal, and how far it is. */
export function StageSteps({ goal }: { goal: Goal }) {
  const seen = useTopic("stages").get(goal.goal_id) ?? [];
  const verb = useVerbOf()(goal);
  const steps = stepsOf(goal, seen, verb);
  if (steps.length === 0) return null;
  return (
    <ol className={classes.steps} aria-label="Stages" data-testid="stages">
      {steps.map(({ stage, label, state }, index) => (
        <li
          key={stage}
          className={classes.step}
          data-state={state}
          aria-current={state === "current" ? "step" : undefined}
        >
          <span className={classes.sign} aria-hidden="true">
            {SIGNS[state] || index + 1}
          </span>
          <Text span size="sm" fw={state === "current" ? 600 : 400}>
            {label}
            <VisuallyHidden>: {SAID[state]}</VisuallyHidden>
          </Text>
        </li>
      ))}
    </ol>
  );
}
