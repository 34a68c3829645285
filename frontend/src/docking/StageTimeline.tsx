import { Text, VisuallyHidden } from "@mantine/core";
import type { Goal } from "../api/types";
import { useGatewayNow } from "../store/clock";
import { useLive } from "../store/context";
import { isTerminal } from "../store/goals";
import { useVerbOf } from "../store/verbs";
import { formatDuration } from "../ui/time";
import classes from "./docking.module.css";
import { type StepState, stageLabel, stepsOf } from "./stages";
import { type StageSpan, spansOf, timeIn } from "./timeline";
import { useWay } from "./useWay";

const SIGNS: Record<StepState, string> = { done: "✓", current: "", failed: "✕", waiting: "" };
const SAID: Record<StepState, string> = {
  done: "done",
  current: "now",
  failed: "did not work",
  waiting: "not yet",
};

/** The stages of a goal, how far it is, and how long each took, in all of its tries. */
export function StageTimeline({ goal }: { goal: Goal }) {
  const visits = useWay(goal);
  const verb = useVerbOf()(goal);
  const now = useGatewayNow(500);
  const known = useLive() || isTerminal(goal.status);
  const seen = visits.map(({ stage }) => stage);
  const steps = stepsOf(goal, seen, verb);
  if (steps.length === 0) return null;
  const spans = spansOf(goal, visits, now);
  const besides = [...new Set(seen)].filter((stage) => steps.every((step) => step.stage !== stage));
  return (
    <div>
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
            <span>
              <Text component="span" size="sm" fw={state === "current" ? 600 : 400} display="block">
                {label}
                <VisuallyHidden>: {SAID[state]}</VisuallyHidden>
              </Text>
              <Text component="span" size="sm" c="dimmed" className="tabular" display="block" mih="1.45em">
                {known && <Duration ms={timeIn(stage, spans)} />}
              </Text>
            </span>
          </li>
        ))}
      </ol>
      {known && <Bar spans={spans} />}
      {known && besides.length > 0 && (
        <Text size="sm" c="dimmed" className="tabular">
          {besides.map((stage, index) => (
            <span key={stage}>
              {index > 0 && ", "}
              {stageLabel(stage) ?? stage} <Duration ms={timeIn(stage, spans)} />
            </span>
          ))}
        </Text>
      )}
    </div>
  );
}

function Duration({ ms }: { ms: number | null }) {
  return ms === null ? null : formatDuration(ms);
}

/** The way to scale, try after try; the list above says the same in words. */
function Bar({ spans }: { spans: readonly StageSpan[] }) {
  if (spans.length < 2 || spans.some(({ ms }) => ms === null)) return null;
  return (
    <div className={classes.bar} aria-hidden="true" data-testid="stage-bar">
      {spans.map(({ stage, ms }, index) => (
        <div
          // biome-ignore lint/suspicious/noArrayIndexKey: the same stage comes again with each try
          key={index}
          className={classes.span}
          data-stage={stage}
          style={{ flexGrow: Math.max(1, ms ?? 0) }}
          title={`${stageLabel(stage) ?? stage}: ${formatDuration(ms ?? 0)}`}
        />
      ))}
    </div>
  );
}
