import { isTerminal } from "@dock-gateway/client";
import { Text, VisuallyHidden } from "@mantine/core";
import { useEffect } from "react";
import { statusesOf } from "../api/goals";
import { useAtTime, useGatewayNow } from "../clock/clock";
import { useFleet } from "../fleet/context";
import { type StepState, spansOf, stageLabel, stepsOf, timeIn } from "../goal/stages";
import { useLive, useServices, useTopicPart } from "../store/context";
import type { GoalCourse } from "../store/goals";
import type { StageVisit } from "../store/stages";
import { formatDuration } from "../ui/time";
import classes from "./docking.module.css";

/** Between two updates of the durations. */
const TEXT_MS = 400;

const SIGNS: Record<StepState, string> = {
  done: "✓",
  current: "",
  failed: "✕",
  canceled: "–",
  unknown: "?",
  waiting: "",
};
const SAID: Record<StepState, string> = {
  done: "done",
  current: "now",
  failed: "did not work",
  canceled: "canceled",
  unknown: "outcome unknown",
  waiting: "not yet",
};

/** The stages of a goal, how far it is, and how long each took, in all of its tries. */
export function StageTimeline({ goal }: { goal: GoalCourse }) {
  const visits = useWay(goal.goal_id);
  const known = useLive() || isTerminal(goal.status);
  const seen = visits.map(({ stage }) => stage);
  const steps = stepsOf(goal, seen);
  if (steps.length === 0) return null;
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
                {known && <TimeIn stage={stage} goal={goal} visits={visits} />}
              </Text>
            </span>
          </li>
        ))}
      </ol>
      {known && <Bar goal={goal} visits={visits} />}
      {known && besides.length > 0 && (
        <Text size="sm" c="dimmed" className="tabular">
          {besides.map((stage, index) => (
            <span key={stage}>
              {index > 0 && ", "}
              {stageLabel(stage) ?? stage} <TimeIn stage={stage} goal={goal} visits={visits} />
            </span>
          ))}
        </Text>
      )}
    </div>
  );
}

interface Way {
  goal: GoalCourse;
  visits: readonly StageVisit[];
}

/** How long a goal was in a stage: a text of its own, which changes while nothing else does. */
function TimeIn({ stage, goal, visits }: Way & { stage: string }) {
  return useAtTime((now) => {
    const ms = timeIn(stage, spansOf(goal, visits, now));
    if (ms !== null) return formatDuration(ms);
    return visits.some((visit) => visit.stage === stage) ? "time unknown" : "";
  }, TEXT_MS);
}

/** The way to scale, try after try; the list above says the same in words. */
function Bar({ goal, visits }: Way) {
  const spans = spansOf(goal, visits, useGatewayNow());
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

const NONE: readonly StageVisit[] = [];

/** The stages that a goal was in. What it was in before this page was opened is read from its history. */
function useWay(goalId: string): readonly StageVisit[] {
  const { http } = useFleet();
  const { store } = useServices();
  const live = useLive();
  const visits = useTopicPart("stages", (stages) => stages.get(goalId) ?? NONE);
  const incomplete = live && visits.some(({ since }) => since === null);

  useEffect(() => {
    if (!incomplete) return;
    let wanted = true;
    statusesOf(http, goalId)
      .then((statuses) => wanted && store.setWay(goalId, statuses))
      // The stages are shown all the same, without their times.
      .catch(() => {});
    return () => {
      wanted = false;
    };
  }, [http, store, goalId, incomplete]);

  return visits;
}
