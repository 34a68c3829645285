import { Button, Group, SegmentedControl, Stack, Text } from "@mantine/core";
import { useId, useMemo, useState } from "react";
import type { Verb } from "../api/client";
import type { ActionServer, Goal } from "../api/types";
import { CHARGING, FULL } from "../battery/words";
import { useLive, useServices, useTopic } from "../store/context";
import { isTerminal, newestFirst } from "../store/goals";
import { useVerbOf } from "../store/verbs";
import { CommandErrorAlert } from "../ui/CommandErrorAlert";
import { Section } from "../ui/Section";
import { useCommand } from "../ui/useCommand";
import { ActionServerStatus } from "./ActionServerStatus";
import classes from "./docking.module.css";
import { GoalPanel } from "./GoalPanel";
import { currentGoal } from "./goalWords";

/** Dock, Undock, Cancel, and the goal that runs. */
export function DockingCard() {
  const { gateway, store } = useServices();
  const live = useLive();
  const servers = { dock: useTopic("actionServer"), undock: useTopic("undockServer") };
  const stopped = useTopic("stop").latched;
  const verbOf = useVerbOf();
  const goals = useTopic("goals");
  const sorted = useMemo(() => newestFirst(goals), [goals]);
  const goal = currentGoal(sorted);
  const running = goal !== null && !isTerminal(goal.status) ? goal : null;
  const others = sorted.filter((each) => !isTerminal(each.status) && each !== running).length;
  const [target, setTarget] = useState(String(CHARGING));
  const reasonId = useId();
  const targetId = useId();

  const dock = useCommand(async (status: number) => store.addGoals([await gateway.dock(status)]));
  const undock = useCommand(async () => store.addGoals([await gateway.undock()]));
  const cancel = useCommand(async (each: Goal) =>
    store.addGoals([await gateway.cancel(verbOf(each), each.goal_id)]),
  );
  const commands = [dock, undock, cancel];
  const begin = () => {
    for (const command of commands) command.reset();
  };

  const common = whyNotSend(live, stopped, running, dock.isPending || undock.isPending);
  const dockReason = common ?? whyNobody("dock", servers.dock);
  const undockReason = common ?? whyNobody("undock", servers.undock);
  const cancelReason = whyNotCancel(live, running, cancel.isPending);
  const reasons = [dockReason, undockReason, cancelReason].filter((reason) => reason !== null);
  const silent = dockReason === null && servers.dock?.answering === false;

  return (
    <Section title="Docking" aside={<ActionServerStatus />}>
      <Group gap="md" align="center">
        <Group gap="xs" className={classes.verbs}>
          <Button
            size="lg"
            disabled={dockReason !== null}
            aria-describedby={reasonId}
            onClick={() => {
              begin();
              dock.mutate(Number(target));
            }}
          >
            Dock
          </Button>
          <Button
            size="lg"
            variant="light"
            disabled={undockReason !== null}
            aria-describedby={reasonId}
            onClick={() => {
              begin();
              undock.mutate();
            }}
          >
            Undock
          </Button>
          <Button
            size="lg"
            variant="default"
            disabled={cancelReason !== null}
            aria-describedby={reasonId}
            onClick={() => running && cancel.mutate(running)}
          >
            Cancel
          </Button>
        </Group>
        <Group gap="xs">
          <Text size="sm" id={targetId}>
            Dock until the battery is
          </Text>
          <SegmentedControl
            aria-labelledby={targetId}
            value={target}
            onChange={setTarget}
            data={[
              { label: "Charging", value: String(CHARGING) },
              { label: "Full", value: String(FULL) },
            ]}
          />
        </Group>
      </Group>
      <Text size="sm" c="dimmed" id={reasonId} role="status">
        {[...new Set(reasons)].join(" ")}{" "}
        {silent && <strong>The action server is there but does not answer: a goal may time out.</strong>}
      </Text>
      <CommandErrorAlert command="Dock" error={dock.error} onClose={dock.reset} />
      <CommandErrorAlert command="Undock" error={undock.error} onClose={undock.reset} />
      <CommandErrorAlert command="Cancel" error={cancel.error} onClose={cancel.reset} />
      {goal === null ? <NoGoal /> : <GoalPanel goal={goal} />}
      {others > 0 && (
        <Text size="sm">
          {others === 1 ? "One more goal is running" : `${others} more goals are running`}: see Recent goals.
        </Text>
      )}
    </Section>
  );
}

const NOT_CONNECTED = "Dock, Undock and Cancel need the gateway, which is not connected.";

const SERVERS: Record<Verb, string> = {
  dock: "connect_to_charging_dock_server or docking_server",
  undock: "docking_server",
};

function whyNotSend(live: boolean, stopped: boolean, running: Goal | null, pending: boolean): string | null {
  if (!live) return NOT_CONNECTED;
  if (stopped) return "Dock and Undock: the robot is stopped; release the stop first.";
  if (pending) return "Sending the goal; waiting for the action server's answer.";
  return running === null ? null : "Dock and Undock: a goal is running; cancel it first.";
}

function whyNobody(verb: Verb, server: ActionServer | null): string | null {
  if (server?.available === true) return null;
  const name = server === null ? "" : ` ${server.action_name}`;
  return `${verb === "dock" ? "Dock" : "Undock"}: nobody offers the action${name}. Start ${SERVERS[verb]}.`;
}

function whyNotCancel(live: boolean, running: Goal | null, pending: boolean): string | null {
  if (!live) return NOT_CONNECTED;
  if (running === null) return "Cancel: no goal is running.";
  if (pending || running.status === "canceling") return "Cancel: the goal is being canceled.";
  if (running.status === "pending") return "Cancel: the action server has not answered yet.";
  return null;
}

function NoGoal() {
  return (
    <Stack gap={4}>
      <Text fw={600}>No goal yet</Text>
      <Text size="sm" c="dimmed">
        Press Dock to send a goal to the docking action server. It reports the battery state as feedback and
        moves the robot until the battery says that it is charging. A goal that someone else sends, such as{" "}
        <em>ros2 action send_goal</em>, appears here as well.
      </Text>
    </Stack>
  );
}
