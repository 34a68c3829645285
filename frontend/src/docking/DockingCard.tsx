import { Stack, Text } from "@mantine/core";
import { useFleetPart } from "../fleet/context";
import { defaultRobot } from "../fleet/names";
import { currentGoal } from "../goal/words";
import { useServices, useTopic } from "../store/context";
import { isTerminal } from "../store/goals";
import { Command } from "../ui/CopyButton";
import { Section } from "../ui/Section";
import { ActionServerStatus } from "./ActionServerStatus";
import { DockingControls } from "./DockingControls";
import { GoalPanel } from "./GoalPanel";

/** What the robot can be asked to do, and the goal that runs. */
export function DockingCard() {
  const goals = useTopic("courses");
  const goal = currentGoal(goals);
  const running = goal !== null && !isTerminal(goal.status) ? goal : null;
  const others = goals.filter((each) => !isTerminal(each.status) && each !== running).length;

  return (
    <Section title="Docking" aside={<ActionServerStatus />}>
      <JoinHint />
      <DockingControls running={running} />
      {goal === null ? <NoGoal /> : <GoalPanel goal={goal} />}
      {others > 0 && (
        <Text size="sm">
          {others === 1 ? "One more goal is running" : `${others} more goals are running`}: see Recent goals.
        </Text>
      )}
    </Section>
  );
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

/** How the robot gets a docking server that is in another namespace: the lines to set. */
export function JoinHint() {
  const { robot } = useServices();
  const join = useFleetPart("robots", (robots) => robots.get(robot ?? defaultRobot(robots))?.join ?? null);
  if (join === null) return null;
  return (
    <Stack gap={4} data-testid="join">
      <Text size="sm">
        No docking server is in this robot's namespace, but one without a battery is in another. If it is this
        robot's, set this where the gateway is started, and restart it:
      </Text>
      {join.settings.map((line) => (
        <Command key={line} line={line} what="the setting" />
      ))}
    </Stack>
  );
}
