import type { ActionServer } from "@dock-gateway/client";
import { Anchor, Button, Group, Table, Text } from "@mantine/core";
import { type MouseEvent, memo, useState } from "react";
import { Link, useNavigate } from "react-router";
import { apiAddress } from "../api/site";
import { Parts } from "../extension/context";
import type { GoalInList } from "../extension/extension";
import { useNaming } from "../fleet/context";
import { goalPath } from "../fleet/names";
import { GoalDuration, GoalStatusBadge, OriginBadge } from "../goal/facts";
import { goalName, goalTitle, outcome } from "../goal/words";
import { useTopic } from "../store/context";
import { Breakable } from "../ui/Fact";
import { Section } from "../ui/Section";
import { Time } from "../ui/Time";
import { sentence } from "../ui/text";
import { goalsPath } from "./filter";
import classes from "./goals.module.css";

interface GoalsTableProps {
  goals: readonly GoalInList[];
  /** Whether it is about one robot, whose actions need no names. */
  oneRobot?: boolean;
}

/** Goals, a row each, which leads to the goal's page. */
export function GoalsTable({ goals, oneRobot = false }: GoalsTableProps) {
  const naming = useNaming();
  return (
    <Table verticalSpacing="xs" horizontalSpacing={8} highlightOnHover className={classes.table ?? ""}>
      <GoalsHead oneRobot={oneRobot} />
      <Table.Tbody>
        {goals.map((goal) => (
          <GoalRow
            key={goal.goal_id}
            goal={goal}
            title={oneRobot ? goalName(goal) : goalTitle(goal, naming)}
            oneRobot={oneRobot}
          />
        ))}
      </Table.Tbody>
    </Table>
  );
}

export function GoalsHead({ oneRobot }: { oneRobot: boolean }) {
  return (
    <Table.Thead>
      <Table.Tr>
        <Table.Th className={classes.started}>Started</Table.Th>
        <Table.Th {...(oneRobot ? { visibleFrom: "xs" } : {})}>Goal</Table.Th>
        <Table.Th>Status</Table.Th>
        <Table.Th visibleFrom="sm">Origin</Table.Th>
        <Table.Th visibleFrom="sm">Duration</Table.Th>
        <Table.Th {...(oneRobot ? {} : { visibleFrom: "sm" })}>Outcome</Table.Th>
      </Table.Tr>
    </Table.Thead>
  );
}

interface GoalRowProps {
  goal: GoalInList;
  /** In words. */
  title: string;
  oneRobot: boolean;
}

const GoalRow = memo(function GoalRow({ goal, title, oneRobot }: GoalRowProps) {
  const navigate = useNavigate();
  const path = goalPath(goal.goal_id, goal.action_name);
  const open = ({ target }: MouseEvent) => {
    const meant = !(target instanceof Element && target.closest("a")) && !window.getSelection()?.toString();
    if (meant) navigate(path);
  };
  return (
    <Table.Tr className={classes.row} onClick={open}>
      <Table.Td className={classes.started}>
        <Link to={path} className={classes.open}>
          <Time value={goal.created_at} />
        </Link>
      </Table.Td>
      {oneRobot ? (
        <Table.Td visibleFrom="xs" title={goal.action_name}>
          <div className={classes.titled}>
            {title}
            <Parts at="listedGoal" goal={goal} quiet />
          </div>
        </Table.Td>
      ) : (
        <Table.Td className={classes.action}>
          <div className={classes.titled}>
            <div>
              <Text size="sm" fw={600}>
                {title}
              </Text>
              <Text size="xs" c="dimmed">
                <Breakable text={goal.action_name} />
              </Text>
            </div>
            <Parts at="listedGoal" goal={goal} quiet />
          </div>
          {goal.tags != null && goal.tags.length > 0 && <Tags tags={goal.tags} />}
        </Table.Td>
      )}
      <Table.Td>
        <GoalStatusBadge status={goal.status} />
      </Table.Td>
      <Table.Td visibleFrom="sm">
        <OriginBadge origin={goal.origin} />
      </Table.Td>
      <Table.Td visibleFrom="sm" className={`tabular ${classes.duration}`}>
        <GoalDuration goal={goal} />
      </Table.Td>
      <Table.Td {...(oneRobot ? {} : { visibleFrom: "sm" })}>
        <Text size="sm" lineClamp={2} title={goal.error?.detail}>
          {sentence(outcome(goal))}
        </Text>
      </Table.Td>
    </Table.Tr>
  );
});

/** Each leads to the goals that have it. */
function Tags({ tags }: { tags: readonly string[] }) {
  return (
    <Group gap={4} mt={4}>
      {tags.map((tag) => (
        <Link key={tag} to={goalsPath({ tags: [tag] })} className={classes.tag}>
          {tag}
        </Link>
      ))}
    </Group>
  );
}

const PAGE = 10;

/** Goals of a robot, newest first, whoever sent them; each leads to its page. */
export function GoalsCard() {
  const goals = useTopic("courses");
  const [shown, setShown] = useState(PAGE);
  const all = allGoals([useTopic("actionServer"), useTopic("undockServer")]);

  return (
    <Section
      title="Recent goals"
      aside={
        <Anchor component={Link} to={all} size="sm">
          All goals
        </Anchor>
      }
    >
      {goals.length === 0 ? (
        <Text size="sm" c="dimmed">
          Every goal on the docking and undocking actions is listed here: those sent from this page, over
          HTTP, and by other ROS nodes. Press Dock, or type <em>curl -X POST {apiAddress()}/dock</em>
        </Text>
      ) : (
        <GoalsTable goals={goals.slice(0, shown)} oneRobot />
      )}
      {goals.length > shown && (
        <Button variant="default" onClick={() => setShown((count) => count + PAGE)}>
          Show {Math.min(goals.length - shown, PAGE)} more
        </Button>
      )}
    </Section>
  );
}

/** The list of all goals on the robot's docking actions. */
function allGoals(servers: readonly (ActionServer | null)[]): string {
  const names = servers.flatMap((server) => (server === null ? [] : [server.action_name]));
  return goalsPath({ actions: names });
}
