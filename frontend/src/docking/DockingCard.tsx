import { Stack, Text } from "@mantine/core";
import { currentGoal } from "../goal/words";
import { useTopic } from "../store/context";
import { isTerminal } from "../store/goals";
import { Section } from "../ui/Section";
import { ActionServerStatus } from "./ActionServerStatus";
import { DockingControls } from "./DockingControls";
import { GoalPanel } from "./GoalPanel";
import { JoinHint } from "./JoinHint";

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
