import { type Approval, deadline, settle } from "@dock-gateway/client";
import { Anchor, Code, Group, Paper, Text } from "@mantine/core";
import { Link } from "react-router";
import { ownId } from "../api/places";
import { useFleet, useNaming, useWhyNot } from "../fleet/context";
import { robotPath } from "../fleet/names";
import { dockOf } from "../goal/words";
import { CommandErrorAlert } from "../ui/errors";
import { ReasonButton } from "../ui/ReasonButton";
import { useCommand } from "../ui/requests";
import { Time } from "../ui/Time";
import classes from "./approvals.module.css";

/** The number of characters of a goal to show. */
const GOAL = 300;

/** Asks whether a robot may get the goal of an agent. */
export default function Question({ approval }: { approval: Approval }) {
  const { id, agent, client, robot, action_name, verb, goal, expires_at } = approval;
  const naming = useNaming();
  const { httpOf, store } = useFleet();
  const answer = useCommand(async (allow: boolean) => {
    const params = { path: { approval_id: ownId(id, robot) } };
    await settle(
      httpOf(robot).PUT("/approvals/{approval_id}/decision", { body: { allow }, params, signal: deadline() }),
    );
    store.setAnswered(id);
  });
  const forbidden = useWhyNot("PUT /approvals/{approval_id}/decision");
  const reason = forbidden ?? (answer.isPending ? "The gateway has not answered yet." : null);
  const what = verb ?? `send a goal to ${action_name}`;
  const dock = verb === "dock" ? dockOf(goal) : null;
  const at = dock === null ? "" : ` at ${dock}`;
  const name = verb === null ? what : `${what} ${naming.fullNameOf(robot)}${at}`;
  return (
    <Paper
      component="section"
      aria-label={`${agent} wants to ${name}`}
      withBorder
      radius="md"
      p="md"
      className={classes.question}
      data-testid="approval"
    >
      <div className={classes.words}>
        <Text fw={700}>
          {agent} wants to {what}
          {verb !== null && (
            <>
              {" "}
              <Anchor component={Link} to={robotPath(robot)} inherit underline="always">
                {naming.fullNameOf(robot)}
              </Anchor>
              {at}
            </>
          )}
        </Text>
        {verb === null && <Code>{JSON.stringify(goal).slice(0, GOAL)}</Code>}
        <Text size="sm">
          An agent{client !== null && `, ${client},`} asks. Check that the area is clear. Without an answer it
          is refused at <Time value={expires_at} />.
        </Text>
      </div>
      <Group gap="xs" className={classes.answers}>
        <ReasonButton
          variant="default"
          reason={reason}
          aria-label={`Refuse: ${name}`}
          onClick={() => answer.mutate(false)}
        >
          Refuse
        </ReasonButton>
        <ReasonButton reason={reason} aria-label={`Allow: ${name}`} onClick={() => answer.mutate(true)}>
          Allow
        </ReasonButton>
      </Group>
      {answer.error !== null && (
        <div className={classes.failed}>
          <CommandErrorAlert command="The answer" error={answer.error} onClose={answer.reset} />
        </div>
      )}
    </Paper>
  );
}
