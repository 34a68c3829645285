import { Button, Group, SegmentedControl, Stack, Text } from "@mantine/core";
import { useId, useMemo, useState } from "react";
import type { ActionServer, Goal } from "../api/types";
import { CHARGING, FULL } from "../battery/words";
import { useLive, useServices, useTopic } from "../store/context";
import { isTerminal, newestFirst } from "../store/goals";
import { CommandErrorAlert } from "../ui/CommandErrorAlert";
import { Section } from "../ui/Section";
import { useCommand } from "../ui/useCommand";
import { GoalPanel } from "./GoalPanel";
import { currentGoal } from "./goalWords";

/** Dock, Cancel, and the goal that runs. */
export function DockingCard() {
  const { gateway, store } = useServices();
  const live = useLive();
  const server = useTopic("actionServer");
  const goals = useTopic("goals");
  const sorted = useMemo(() => newestFirst(goals), [goals]);
  const goal = currentGoal(sorted);
  const running = goal !== null && !isTerminal(goal.status) ? goal : null;
  const others = sorted.filter((each) => !isTerminal(each.status) && each !== running).length;
  const [target, setTarget] = useState(String(CHARGING));
  const reasonId = useId();
  const targetId = useId();

  const dock = useCommand(async (status: number) => store.addGoals([await gateway.dock(status)]));
  const cancel = useCommand(async (goalId: string) => store.addGoals([await gateway.cancel(goalId)]));

  const dockReason = whyNotDock(live, server, running, dock.isPending);
  const cancelReason = whyNotCancel(live, running, cancel.isPending);
  const reasons = [dockReason, cancelReason].filter((reason) => reason !== null);

  return (
    <Section title="Docking">
      <Group gap="md" align="center">
        <Group gap="sm">
          <Button
            size="lg"
            disabled={dockReason !== null}
            aria-describedby={reasonId}
            onClick={() => {
              cancel.reset();
              dock.mutate(Number(target));
            }}
          >
            Dock
          </Button>
          <Button
            size="lg"
            variant="default"
            disabled={cancelReason !== null}
            aria-describedby={reasonId}
            onClick={() => running && cancel.mutate(running.goal_id)}
          >
            Cancel
          </Button>
        </Group>
        <Group gap="xs">
          <Text size="sm" id={targetId}>
            until the battery is
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
        {dockReason === null && server?.answering === false && (
          <strong>The action server is there but does not answer: a goal may time out.</strong>
        )}
      </Text>
      <CommandErrorAlert command="Dock" error={dock.error} onClose={dock.reset} />
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

const NOT_CONNECTED = "Dock and Cancel need the gateway, which is not connected.";

function whyNotDock(
  live: boolean,
  server: ActionServer | null,
  running: Goal | null,
  pending: boolean,
): string | null {
  if (!live) return NOT_CONNECTED;
  if (pending) return "Sending the goal; waiting for the action server's answer.";
  if (running !== null) return "Dock: a goal is running; cancel it first.";
  if (server?.available === false) {
    return `Dock: nobody offers the action ${server.action_name}. Start the action server: connect_to_charging_dock_server.`;
  }
  return null;
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
        turns the robot until the battery says that it is charging. A goal that someone else sends, such as{" "}
        <em>ros2 action send_goal</em>, appears here as well.
      </Text>
    </Stack>
  );
}
