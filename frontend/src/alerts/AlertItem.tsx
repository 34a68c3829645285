import { Anchor, Group, Text } from "@mantine/core";
import { memo } from "react";
import { Link } from "react-router";
import { createAlerts } from "../api/client";
import type { Alert } from "../api/types";
import { useFleet, useNaming } from "../fleet/context";
import { robotPath } from "../fleet/path";
import { CommandErrorAlert } from "../ui/errors";
import { ReasonButton } from "../ui/ReasonButton";
import { useCommand } from "../ui/requests";
import { Time } from "../ui/Time";
import { AcknowledgeButton, useWhyNotAnswer } from "./AcknowledgeButton";
import classes from "./alerts.module.css";
import { SeverityMark } from "./marks";

/** One alert: what it is, what to do, and who has seen it. */
export const AlertItem = memo(function AlertItem({ alert }: { alert: Alert }) {
  const naming = useNaming();
  const { id, robot, severity, title, detail, since, goal_id, acknowledged } = alert;
  const what = robot === null ? title : `${title}: ${naming.fullNameOf(robot)}`;
  return (
    <li
      className={classes.alert}
      data-severity={severity}
      data-acknowledged={acknowledged !== null || undefined}
    >
      <SeverityMark mark={acknowledged === null ? severity : "acknowledged"} />
      <div className={classes.words}>
        <Text fw={600}>
          {title}
          {robot !== null && (
            <>
              {": "}
              <Anchor component={Link} to={robotPath(robot)} inherit underline="always">
                {naming.fullNameOf(robot)}
              </Anchor>
            </>
          )}
        </Text>
        <Text size="sm">{detail}</Text>
        <Text size="sm" c="dimmed">
          {severity === "critical" ? "Critical" : "Warning"}, since <Time value={since} />
          {goal_id !== null && (
            <>
              {". "}
              <Anchor component={Link} to={`/ui/goals/${goal_id}`} underline="always">
                See the goal
              </Anchor>
            </>
          )}
        </Text>
      </div>
      {acknowledged === null ? (
        <AcknowledgeButton id={id} what={what} />
      ) : (
        <Acknowledged id={id} what={what} {...acknowledged} />
      )}
    </li>
  );
});

interface AcknowledgedProps {
  id: string;
  what: string;
  by: string;
  at: string;
}

function Acknowledged({ id, what, by, at }: AcknowledgedProps) {
  const { http, store } = useFleet();
  const withdraw = useCommand(async () => store.setAlert(await createAlerts(http).withdraw(id)));
  const reason = useWhyNotAnswer(withdraw.isPending);
  return (
    <>
      <Group gap="xs" className={classes.answer}>
        <Text size="sm" role="status">
          Acknowledged by <strong>{by}</strong> at <Time value={at} />
        </Text>
        <ReasonButton
          variant="subtle"
          size="compact-sm"
          reason={reason}
          aria-label={`Withdraw: ${what}`}
          onClick={() => withdraw.mutate()}
        >
          Withdraw
        </ReasonButton>
      </Group>
      {withdraw.error !== null && (
        <div className={classes.failed}>
          <CommandErrorAlert command="Withdraw" error={withdraw.error} onClose={withdraw.reset} />
        </div>
      )}
    </>
  );
}
