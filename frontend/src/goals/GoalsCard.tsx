import { Anchor, Button, Text } from "@mantine/core";
import { useState } from "react";
import { Link } from "react-router";
import type { ActionServer } from "../api/types";
import { useTopic } from "../store/context";
import { Section } from "../ui/Section";
import { NO_FILTER, writeFilter } from "./filter";
import { GoalsTable } from "./GoalsTable";

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
          HTTP, and by other ROS nodes. Press Dock, or type{" "}
          <em>curl -X POST {window.location.origin}/dock</em>
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
  return `/ui/goals?${writeFilter({ ...NO_FILTER, actions: names })}`;
}
