import { type ActionServer, isTerminal } from "@dock-gateway/client";
import { Badge, Stack, Text, Tooltip, VisuallyHidden } from "@mantine/core";
import { useRobotPart } from "../fleet/robot";
import { currentGoal } from "../goal/words";
import { useLive, useTopic } from "../store/context";
import { Command } from "../ui/CopyButton";
import { Section } from "../ui/Section";
import { DockingControls } from "./DockingControls";
import { foreignName, whatToStart } from "./families";
import { GoalPanel } from "./GoalPanel";

/** What the robot can be asked to do, and the goal that runs. */
export function DockingCard() {
  const goals = useTopic("courses");
  const goal = currentGoal(goals);
  const running = goal !== null && !isTerminal(goal.status) ? goal : null;
  const others = goals.filter((each) => !isTerminal(each.status) && each !== running).length;

  return (
    <Section title="Docking" help="docking#what-the-dock-server-does" aside={<ActionServerStatus />}>
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
function JoinHint() {
  const join = useRobotPart((robot) => robot?.join ?? null);
  if (join === null) return null;
  return (
    <Stack gap={4} data-testid="join">
      <Text size="sm">
        No docking server is in this robot's namespace, but one without a battery is in another. If it is this
        robot's, set this in the gateway's configuration file, and restart it:
      </Text>
      {join.settings.map((line) => (
        <Command key={line} line={line} what="the setting" />
      ))}
    </Stack>
  );
}

/** Whether the docking server can be reached; that it answers, as it should, is said to screen readers alone. */
function ActionServerStatus() {
  const server = useTopic("actionServer");
  const live = useLive();
  const foreign = server === null ? null : foreignName(server);
  const trouble = describe(live ? server : null);
  return (
    <div role="status" data-testid="action-server">
      {trouble === null ? (
        <>
          {foreign !== null && (
            <Tooltip label={`${server?.action_name} (${server?.action_type})`} multiline maw={320}>
              <Badge color="gray" variant="light" data-testid="docking-family">
                {foreign}
              </Badge>
            </Tooltip>
          )}
          <VisuallyHidden>action server answering</VisuallyHidden>
        </>
      ) : (
        <Tooltip label={trouble.hint} multiline maw={280}>
          <Badge color={trouble.color}>{trouble.label}</Badge>
        </Tooltip>
      )}
    </div>
  );
}

/** What is wrong with it; null where nothing is. */
function describe(server: ActionServer | null): { label: string; color: string; hint: string } | null {
  if (server === null) {
    return {
      label: "action server unknown",
      color: "gray.7",
      hint: "Known again when the gateway is connected.",
    };
  }
  if (!server.available) {
    return {
      label: "action server not there",
      color: "red",
      hint: `No action server for ${server.action_name}. Start ${whatToStart("dock", server)}.`,
    };
  }
  if (server.duplicate) {
    return {
      label: "two action servers",
      color: "red",
      hint: `More than one action server serves ${server.action_name}: each of them would move the robot.`,
    };
  }
  return server.answering
    ? null
    : {
        label: "action server silent",
        color: "orange",
        hint: `${server.action_name} is on the graph but does not answer. It may be frozen.`,
      };
}
