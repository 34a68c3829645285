import { isTerminal, type LiveGoal } from "@dock-gateway/client";
import { Button, Group, Text } from "@mantine/core";
import { useState } from "react";
import { Section } from "../../ui/Section";
import { formatElapsed } from "../../ui/time";
import classes from "./recordings.module.css";
import type { GoalReplay } from "./requests";
import { useReplay } from "./useReplay";

type Line = GoalReplay["log"][number] & { times?: number };

const LEVELS = { info: null, warning: "Warning", error: "Error", fatal: "Fatal error" };
/** How many of the last lines are shown at first, and how many of those that warn. */
const LAST = 8;
const WARNING = 12;
/** Within which a diagnosis is that of a line (s). */
const AT_ONCE = 0.1;

/** What nodes of the robot logged while a goal ran, and what its diagnostics warned of; nothing without a recording. */
export default function GoalLog({ goal }: { goal: LiveGoal }) {
  const { data } = useReplay(goal);
  const [all, setAll] = useState(false);
  if (!isTerminal(goal.status) || data === undefined || data.log.length === 0) return null;
  const log = readable(data.log, goal.goal_id);
  const first = mostTelling(log);
  return (
    <Section title="Log">
      <ol className={classes.log}>
        {(all ? log : first).map((line, index) => (
          // biome-ignore lint/suspicious/noArrayIndexKey: two lines may be the same, and none is ever moved
          <LogLine key={index} line={line} />
        ))}
      </ol>
      {first.length < log.length && (
        <Group>
          <Button variant="default" size="compact-sm" aria-expanded={all} onClick={() => setAll(!all)}>
            {all ? "Show fewer" : `Show all ${log.length} lines`}
          </Button>
        </Group>
      )}
    </Section>
  );
}

function LogLine({ line: { offset_s, level, node, text, times = 1 } }: { line: Line }) {
  const word = LEVELS[level];
  return (
    <li data-level={level}>
      <Text span size="sm" c="dimmed" className="tabular">
        {formatElapsed(offset_s, 1)}
      </Text>
      <div>
        <Text size="sm" className={classes.logText}>
          {word !== null && <strong>{word}: </strong>}
          {text}
          {times > 1 && ` (${times} times)`}
        </Text>
        <Text size="xs" c="dimmed" className={classes.logText}>
          {node}
        </Text>
      </div>
    </li>
  );
}

/**
 * The lines without what says nothing: the id of the goal that the page is about, what was said at once in other words,
 * and one line again and again.
 */
export function readable(log: readonly Line[], goalId: string): readonly Line[] {
  const lines: Line[] = [];
  for (const { text: said, ...line } of log) {
    const text = said.replaceAll(`Goal ${goalId}: `, "").replaceAll(`Goal ${goalId}`, "Goal");
    const last = lines.at(-1);
    if (last?.text === text && last.node === line.node && last.level === line.level)
      last.times = (last.times ?? 1) + 1;
    else if (!log.some((other) => isSaidIn({ ...line, text: said }, other))) lines.push({ ...line, text });
  }
  return lines;
}

/** Whether a line is a part of another one that came at about the same time. */
function isSaidIn(line: Line, other: Line): boolean {
  const longer = other.text.length > line.text.length && other.text.includes(line.text);
  return longer && Math.abs(other.offset_s - line.offset_s) <= AT_ONCE;
}

/** The last lines, and before them those that warn. */
export function mostTelling(log: readonly Line[]): readonly Line[] {
  const last = log.slice(-LAST);
  const before = log.slice(0, -LAST).filter(({ level }) => level !== "info");
  return [...before.slice(-WARNING), ...last];
}
