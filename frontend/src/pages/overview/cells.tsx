import { Anchor, Badge } from "@mantine/core";
import { memo } from "react";
import { Link } from "react-router";
import type { GoalSummary, Robot } from "../../api/types";
import { useAtTime } from "../../clock/clock";
import { linkOf } from "../../fleet/words";
import { goalName, lastWords, runningWords, soFarWords } from "../../goal/words";
import { Time } from "../../ui/Time";
import classes from "./overview.module.css";

/** What a robot does now: it is stopped, runs a goal, or nothing; unknown where nothing of it is heard. */
export function NowCell({ robot, live }: { robot: Robot; live: boolean }) {
  const [goal, ...others] = robot.goals;
  const { latched, by } = robot.stop;
  return (
    <>
      {latched && <Badge color="red">Stopped{by !== null && ` by ${by}`}</Badge>}
      {goal !== undefined && (
        <Running
          goalId={goal.goal_id}
          words={runningWords(goal)}
          since={Date.parse(goal.created_at)}
          retries={goal.retries ?? 0}
          stalled={goal.stalled}
          live={live}
        />
      )}
      {others.length > 0 && (
        <span className={classes.quiet}>and {others.map((each) => goalName(each)).join(", ")}</span>
      )}
      {goal === undefined && !latched && (
        <span className={classes.empty}>{linkOf(robot) === "unreachable" ? "Unknown" : "Idle"}</span>
      )}
    </>
  );
}

interface RunningProps {
  goalId: string;
  words: string;
  since: number;
  retries: number;
  stalled: boolean;
  live: boolean;
}

const Running = memo(function Running({ goalId, words, since, retries, stalled, live }: RunningProps) {
  return (
    <span className={classes.running}>
      <Anchor component={Link} to={`/ui/goals/${goalId}`} inherit className={classes.above}>
        {words}
      </Anchor>
      {live && <Elapsed since={since} />}
      {retries > 0 && <Badge color="orange">{retries === 1 ? "1 retry" : `${retries} retries`}</Badge>}
      {stalled && <Badge color="orange">stalled</Badge>}
    </span>
  );
});

function Elapsed({ since }: { since: number }) {
  return <span className={classes.quiet}>{useAtTime((now) => soFarWords(since, now))}</span>;
}

/** How the last docking or undocking ended, and when. */
export function LastCell({ robot }: { robot: Robot }) {
  const goal = robot.last_goal;
  if (goal === null) return <span className={classes.empty}>No goals yet</span>;
  return <Last goalId={goal.goal_id} words={lastWords(goal)} {...outcomeOf(goal)} />;
}

function outcomeOf({ status, finished_at, updated_at }: GoalSummary) {
  const outcome = status === "succeeded" ? "good" : status === "canceled" ? "neutral" : "bad";
  return { outcome, at: finished_at ?? updated_at } as const;
}

const SIGNS = { good: "✓", neutral: "–", bad: "✕" } as const;

interface LastProps {
  goalId: string;
  words: string;
  outcome: keyof typeof SIGNS;
  at: string;
}

const Last = memo(function Last({ goalId, words, outcome, at }: LastProps) {
  return (
    <span className={classes.last}>
      <span className={classes.sign} data-outcome={outcome} aria-hidden="true">
        {SIGNS[outcome]}
      </span>
      <span>
        <Anchor component={Link} to={`/ui/goals/${goalId}`} inherit className={classes.above}>
          {words}
        </Anchor>{" "}
        <span className={classes.quiet}>
          <Time value={at} />
        </span>
      </span>
    </span>
  );
});
