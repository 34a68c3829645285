import { Anchor, Text, VisuallyHidden } from "@mantine/core";
import type { CSSProperties } from "react";
import { Link } from "react-router";
import { Parts } from "../../extension/context";
import { goalPath } from "../../fleet/names";
import { Time } from "../../ui/Time";
import classes from "./missions.module.css";
import { hasEnded } from "./queue";
import type { Mission, MissionStep } from "./requests";
import { depthOf, errorDetail, errorWords, numberOf, optionWords, STEP_STATES, stepWords } from "./words";

/** The steps of a mission with their states, tries, goals and errors. */
export function MissionSteps({ mission }: { mission: Mission }) {
  const present = mission.started_at === null || hasEnded(mission) ? null : mission.step;
  return (
    <ol className={classes.steps} aria-label="Steps">
      {mission.steps.map((step, index) => (
        <Step key={step.path} step={step} present={index === present} robot={mission.robot} />
      ))}
    </ol>
  );
}

interface StepProps {
  step: MissionStep;
  /** Whether the mission is at this step. */
  present: boolean;
  /** Null before one of its group has begun it. */
  robot: string | null;
}

function Step({ step, present, robot }: StepProps) {
  const { sign, words } = STEP_STATES[step.status];
  const options = optionWords(step);
  const detail = step.error === null ? null : errorDetail(step.error);
  return (
    <li
      className={classes.step}
      data-state={present ? "present" : step.status}
      style={{ "--depth": depthOf(step) } as CSSProperties}
      aria-current={present ? "step" : undefined}
    >
      <span className={classes.sign} aria-hidden="true">
        {sign || numberOf(step)}
      </span>
      <div className={classes.words}>
        <Text size="sm" fw={present ? 600 : 400}>
          {stepWords(step)}
          <VisuallyHidden>: {words}</VisuallyHidden>
          {options !== "" && (
            <Text span size="sm" c="dimmed" fw={400}>
              {" "}
              ({options})
            </Text>
          )}
        </Text>
        <StepFacts step={step} robot={robot} />
        {step.error !== null && (
          <Text size="sm" c={step.status === "failed" ? "var(--mantine-color-error)" : undefined}>
            {step.status !== "failed" && "Last try: "}
            {errorWords(step.error)}
            {detail !== null && (
              <Text span size="sm" c="dimmed">
                . {detail}
              </Text>
            )}
          </Text>
        )}
      </div>
    </li>
  );
}

/** When it began and ended, which try that was, and its goal. */
function StepFacts({ step, robot }: { step: MissionStep; robot: string | null }) {
  const { attempt, tries, started_at, finished_at, goal_id, status } = step;
  if (started_at === null && status !== "skipped") return null;
  const facts = [
    ...(status === "skipped" ? [<span key="skipped">Skipped</span>] : []),
    ...(attempt > 1 || (attempt === 1 && tries > 1 && status !== "succeeded")
      ? [<span key="try">Try {attempt}</span>]
      : []),
    ...(started_at === null
      ? []
      : [
          <span key="time">
            {status === "running" && "Since "}
            <Time value={started_at} />
            {finished_at !== null && (
              <>
                {" – "}
                <Time value={finished_at} />
              </>
            )}
          </span>,
        ]),
    ...(goal_id === null || robot === null
      ? []
      : [
          <Anchor key="goal" component={Link} to={goalPath(goal_id, robot)} size="sm" underline="always">
            Goal {goal_id.slice(0, 8)}
          </Anchor>,
          ...(finished_at === null
            ? []
            : [<Parts key={`linked ${goal_id}`} at="linkedGoal" quiet goalId={goal_id} />]),
        ]),
  ];
  return (
    <Text size="sm" c="dimmed" component="div" className={`tabular ${classes.facts}`}>
      {facts}
    </Text>
  );
}
