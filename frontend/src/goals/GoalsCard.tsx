import { Badge, Button, Table, Text } from "@mantine/core";
import { useMemo, useState } from "react";
import type { Verb } from "../api/client";
import type { Goal } from "../api/types";
import { outcome } from "../docking/goalWords";
import { useGatewayNow } from "../store/clock";
import { useLive, useServices, useTopic } from "../store/context";
import { newestFirst } from "../store/goals";
import { MAX_GOALS } from "../store/state";
import { useVerbOf } from "../store/verbs";
import { CommandErrorAlert } from "../ui/CommandErrorAlert";
import { Section } from "../ui/Section";
import { sentence } from "../ui/sentence";
import { Time } from "../ui/Time";
import { formatDuration } from "../ui/time";
import { useCommand } from "../ui/useCommand";
import { GoalDrawer } from "./GoalDrawer";
import { GoalStatusBadge } from "./GoalStatusBadge";
import classes from "./goals.module.css";

const PAGE = 10;

/** Goals, newest first, whoever sent them; each opens its details. */
export function GoalsCard() {
  const goals = useTopic("goals");
  const sorted = useMemo(() => newestFirst(goals), [goals]);
  const [shown, setShown] = useState(PAGE);
  const [opened, setOpened] = useState<string | null>(null);

  return (
    <Section title="Recent goals">
      {sorted.length === 0 ? (
        <Text size="sm" c="dimmed">
          Every goal on the docking and undocking actions is listed here: those sent from this page, over
          HTTP, and by other ROS nodes. Press Dock, or type{" "}
          <em>curl -X POST {window.location.origin}/dock</em>
        </Text>
      ) : (
        <Table verticalSpacing="xs" horizontalSpacing={8} highlightOnHover>
          <Table.Thead>
            <Table.Tr>
              <Table.Th>Started</Table.Th>
              <Table.Th visibleFrom="xs">Goal</Table.Th>
              <Table.Th>Status</Table.Th>
              <Table.Th visibleFrom="sm">Origin</Table.Th>
              <Table.Th visibleFrom="sm">Duration</Table.Th>
              <Table.Th>Outcome</Table.Th>
            </Table.Tr>
          </Table.Thead>
          <Table.Tbody>
            {sorted.slice(0, shown).map((goal) => (
              <GoalRow key={goal.goal_id} goal={goal} onOpen={() => setOpened(goal.goal_id)} />
            ))}
          </Table.Tbody>
        </Table>
      )}
      {sorted.length > 0 && (
        <MoreGoals loaded={sorted.length} shown={shown} onShow={() => setShown((count) => count + PAGE)} />
      )}
      <GoalDrawer goalId={opened} onClose={() => setOpened(null)} />
    </Section>
  );
}

function GoalRow({ goal, onOpen }: { goal: Goal; onOpen: () => void }) {
  const verb = useVerbOf()(goal);
  return (
    <Table.Tr className={classes.row} onClick={onOpen}>
      <Table.Td>
        <button type="button" className={classes.open} aria-haspopup="dialog">
          <Time value={goal.created_at} />
        </button>
      </Table.Td>
      <Table.Td visibleFrom="xs">{sentence(verb)}</Table.Td>
      <Table.Td>
        <GoalStatusBadge status={goal.status} />
      </Table.Td>
      <Table.Td visibleFrom="sm">
        <Badge variant="outline" color={goal.origin === "external" ? "grape" : "blue"}>
          {goal.origin}
        </Badge>
      </Table.Td>
      <Table.Td visibleFrom="sm" className="tabular">
        <Duration goal={goal} />
      </Table.Td>
      <Table.Td>
        <Text size="sm" lineClamp={2} title={goal.error?.detail}>
          {sentence(outcome(goal, verb))}
        </Text>
      </Table.Td>
    </Table.Tr>
  );
}

function Duration({ goal }: { goal: Goal }) {
  const now = useGatewayNow();
  const live = useLive();
  const start = Date.parse(goal.created_at);
  if (goal.finished_at !== null) return formatDuration(Date.parse(goal.finished_at) - start);
  return live ? formatDuration(now - start) : "not live";
}

const VERBS = ["dock", "undock"] as const;

/** Where the next page of each action begins: undefined before the first was asked for, null after the last. */
type Cursors = Record<Verb, string | null | undefined>;

interface MoreGoalsProps {
  loaded: number;
  shown: number;
  onShow: () => void;
}

/** Shows more of what is loaded, and loads more from the gateway up to what the page keeps. */
function MoreGoals({ loaded, shown, onShow }: MoreGoalsProps) {
  const { gateway, store } = useServices();
  const live = useLive();
  const undocks = useTopic("undockServer") !== null;
  const [cursors, setCursors] = useState<Cursors>({ dock: undefined, undock: undefined });
  const left = VERBS.filter((verb) => cursors[verb] !== null && (verb === "dock" || undocks));
  const load = useCommand(async () => {
    const pages = await Promise.all(left.map((verb) => gateway.goals(verb, cursors[verb] ?? null)));
    store.addGoals(pages.flatMap((page) => page.goals));
    const next = left.map((verb, index) => [verb, pages[index]?.next_cursor ?? null]);
    setCursors((before) => ({ ...before, ...Object.fromEntries(next) }));
    onShow();
  });
  const hidden = loaded - shown;
  const full = loaded >= MAX_GOALS;
  const canLoad = hidden <= 0 && left.length > 0 && !full && loaded >= PAGE;

  if (hidden <= 0 && !canLoad && !full) return null;

  return (
    <>
      {hidden > 0 && (
        <Button variant="default" onClick={onShow}>
          Show {Math.min(hidden, PAGE)} more
        </Button>
      )}
      {canLoad && (
        <Button variant="default" disabled={!live || load.isPending} onClick={() => load.mutate()}>
          Load older goals
        </Button>
      )}
      {hidden <= 0 && full && (
        <Text size="sm" c="dimmed">
          The newest {MAX_GOALS} are kept on this page; GET /dock has the older ones.
        </Text>
      )}
      <CommandErrorAlert command="Loading older goals" error={load.error} onClose={load.reset} />
    </>
  );
}
