import type { GoalSummary, Robot } from "@dock-gateway/client";
import { Anchor, Badge, VisuallyHidden } from "@mantine/core";
import { memo } from "react";
import { Link } from "react-router";
import { type Charge, ChargeBar, chargeOf } from "../../battery/BatteryCard";
import { CHARGING, FULL, formatPercentage, formatQuantity, statusOf, statusWords } from "../../battery/words";
import { useAtTime } from "../../clock/clock";
import { useFleetLive } from "../../fleet/context";
import { goalPath } from "../../fleet/names";
import { ageWords, linkOf } from "../../fleet/words";
import { goalName, lastWords, runningWords, soFarWords } from "../../goal/words";
import { believed } from "../../store/batterySeries";
import { freshnessOf } from "../../store/context";
import { Time } from "../../ui/Time";
import classes from "./overview.module.css";

/** What a robot does now: it is stopped, runs a goal, or nothing; unknown where nothing of it is heard. */
export function NowCell({ robot, live }: { robot: Robot; live: boolean }) {
  const [goal, ...others] = robot.goals;
  const { latched, by } = robot.stop;
  return (
    <>
      {latched && (
        <Badge color="red" className={classes.stopped ?? ""}>
          Stopped{by !== null && ` by ${by}`}
        </Badge>
      )}
      {goal !== undefined && (
        <Running
          path={goalPath(goal.goal_id, goal.action_name)}
          words={runningWords(goal)}
          since={Date.parse(goal.created_at)}
          retries={goal.retries ?? 0}
          stalled={goal.stalled}
          live={live}
        />
      )}
      {goal !== undefined && linkOf(robot) === "away" && <span className={classes.quiet}>last known</span>}
      {others.length > 0 && (
        <span className={classes.quiet}>and {others.map((each) => goalName(each)).join(", ")}</span>
      )}
      {goal === undefined && !latched && (
        <span className={classes.empty}>{isSilent(robot) ? "Unknown" : "Idle"}</span>
      )}
    </>
  );
}

function isSilent(robot: Robot): boolean {
  const link = linkOf(robot);
  return link === "unreachable" || link === "away";
}

interface RunningProps {
  path: string;
  words: string;
  since: number;
  retries: number;
  stalled: boolean;
  live: boolean;
}

const Running = memo(function Running({ path, words, since, retries, stalled, live }: RunningProps) {
  return (
    <span className={classes.running}>
      <Anchor component={Link} to={path} inherit className={classes.above}>
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
  return (
    <Last path={goalPath(goal.goal_id, goal.action_name)} words={lastWords(goal)} {...outcomeOf(goal)} />
  );
}

function outcomeOf({ status, finished_at, updated_at }: GoalSummary) {
  const outcome = status === "succeeded" ? "good" : status === "canceled" ? "neutral" : "bad";
  return { outcome, at: finished_at ?? updated_at } as const;
}

const SIGNS = { good: "✓", neutral: "–", bad: "✕" } as const;

interface LastProps {
  path: string;
  words: string;
  outcome: keyof typeof SIGNS;
  at: string;
}

const Last = memo(function Last({ path, words, outcome, at }: LastProps) {
  return (
    <span className={classes.last}>
      <span className={classes.sign} data-outcome={outcome} aria-hidden="true">
        {SIGNS[outcome]}
      </span>
      <span>
        <Anchor component={Link} to={path} inherit className={classes.above}>
          {words}
        </Anchor>{" "}
        <span className={classes.quiet}>
          <Time value={at} />
        </span>
      </span>
    </span>
  );
});

/** A robot's battery: how full, whether it charges, and how old that is. */
export function BatteryMeter({ battery, charging }: Pick<Robot, "battery" | "charging">) {
  const { received_at, stale_after_s, low_below } = battery;
  const known = believed(battery);
  if (known === null || received_at === null) return <span className={classes.empty}>No data</span>;
  const { percentage, voltage, power_supply_status: status } = known;
  const filled = percentage === null ? null : Math.round(percentage * 100);
  return (
    <div className={classes.battery}>
      <Level
        text={percentage === null ? formatQuantity(voltage, "V") : formatPercentage(percentage)}
        filled={filled === null ? null : Math.min(100, Math.max(0, filled))}
        charge={chargeOf(known, low_below, charging)}
        status={statusOf(status, charging)}
      />
      <Age receivedAt={Date.parse(received_at)} staleAfterMs={stale_after_s * 1000} />
    </div>
  );
}

interface LevelProps {
  text: string;
  /** In percent; null where it is not measured. */
  filled: number | null;
  charge: Charge;
  status: number;
}

/** Changes only where what is shown does: messages come often. */
const Level = memo(function Level({ text, filled, charge, status }: LevelProps) {
  const charging = status === CHARGING;
  return (
    <div className={classes.level}>
      <ChargeBar filled={filled} charge={charge} />
      <span className={classes.percentage}>{text}</span>
      {charging && <Bolt />}
      <span className={classes.status}>
        {status === FULL && "full"}
        <VisuallyHidden>{status === FULL ? "" : statusWords(status).toLowerCase()}</VisuallyHidden>
        {charge === "low" && "low"}
      </span>
    </div>
  );
});

function Bolt() {
  return (
    <svg
      className={classes.bolt}
      width="14"
      height="16"
      viewBox="0 0 14 16"
      aria-hidden="true"
      fill="currentColor"
    >
      <title>Charging</title>
      <path d="M8.5 0 1 9h4.5L4.5 16 13 6H8.2L8.5 0Z" />
    </svg>
  );
}

function Age({ receivedAt, staleAfterMs }: { receivedAt: number; staleAfterMs: number }) {
  const words = useAtTime((now) => ageWords(now - receivedAt));
  const live = useFleetLive();
  const stale = useAtTime((now) => freshnessOf(live, now - receivedAt, staleAfterMs) === "stale");
  return (
    <span className={classes.age} data-stale={stale || undefined}>
      {stale ? `stale: ${words}` : words}
    </span>
  );
}
