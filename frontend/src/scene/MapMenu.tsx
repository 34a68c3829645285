import { type ActionInfo, isTerminal, type Pose } from "@dock-gateway/client";
import { Menu, Stack, Text } from "@mantine/core";
import { notifications } from "@mantine/notifications";
import { useState } from "react";
import { createActionsApi } from "../api/actions";
import { whyForbidden } from "../api/session";
import { whyNotSend } from "../docking/families";
import { MoveDialog, useAsking } from "../docking/MoveDialog";
import { NOT_CONNECTED, useFleet, useFleetPart, useNaming } from "../fleet/context";
import { defaultRobot } from "../fleet/names";
import { currentGoal } from "../goal/words";
import { useLive, useServices, useTopic, useTopicPart } from "../store/context";
import { compose, inverse } from "../store/geometry";
import { groundIn } from "../store/layers";
import { Dialog, QuestionBar } from "../ui/Dialog";
import { CommandErrorAlert } from "../ui/errors";
import { useAnswer, useCommand } from "../ui/requests";
import type { Pick } from "./SceneCanvas";
import classes from "./scene.module.css";
import { describePose } from "./words";

const NAVIGATE = "navigate_to_pose";
const LOOK_EVERY_MS = 10_000;

interface MapMenuProps {
  pick: Pick | null;
  onClose: () => void;
}

/** What can be done at a place of the map: to dock at its dock, or to drive there. Each is asked about as elsewhere. */
export default function MapMenu({ pick, onClose }: MapMenuProps) {
  const { gateway, robot, store, scene, layers } = useServices();
  const naming = useNaming();
  const asking = useAsking();
  const [dock, setDock] = useState<string | null>(null);
  const [drive, setDrive] = useState<Target | null>(null);
  const navigator = useNavigator();
  const why = useWhyNotDock();
  const send = useCommand(async (name: string) => store.addGoals([await gateway.dock(null, name)]));
  const target = pick === null ? null : targetOf(pick);
  const opened = pick !== null && (pick.dock !== null || (navigator !== null && target !== null));
  const dockHere = (name: string) => {
    send.reset();
    if (asking.asks) setDock(name);
    else send.mutate(name);
  };

  return (
    <>
      <Menu
        opened={opened}
        onChange={(next) => !next && onClose()}
        position="bottom-start"
        zIndex={250}
        returnFocus
        withInitialFocusPlaceholder={false}
      >
        <Menu.Target>
          <button
            type="button"
            aria-label="This place of the map"
            className={classes.pick}
            style={pick === null ? undefined : { left: pick.at.x, top: pick.at.y }}
            tabIndex={-1}
          />
        </Menu.Target>
        <Menu.Dropdown aria-label="At this place">
          {pick?.dock != null && (
            <>
              <Menu.Label>{pick.dock.name}</Menu.Label>
              <Entry name="Dock here" reason={why} onClick={() => pick.dock && dockHere(pick.dock.name)} />
            </>
          )}
          {navigator !== null && target !== null && (
            <>
              <Menu.Label>{describePose(target.pose)}</Menu.Label>
              <Entry name="Drive here" reason={navigator.reason} onClick={() => setDrive(target)} />
            </>
          )}
        </Menu.Dropdown>
      </Menu>
      <CommandErrorAlert command="Dock" error={send.error} onClose={send.reset} />
      <MoveDialog
        opened={dock !== null}
        verb="dock"
        robot={robot === null ? null : naming.fullNameOf(robot)}
        dock={dock ?? undefined}
        reason={why}
        onMove={() => {
          if (dock !== null) send.mutate(dock);
          setDock(null);
        }}
        onClose={() => setDock(null)}
      />
      {navigator !== null && (
        <DriveDialog navigator={navigator} target={drive} onClose={() => setDrive(null)} />
      )}
    </>
  );

  /** The place on the map, with the heading of the way there; null where it is not related to the map. */
  function targetOf({ point }: Pick): Target | null {
    const { latest } = scene;
    const ground = latest === null ? null : groundIn(latest, layers);
    if (latest === null || ground === null) return null;
    const theta = Math.atan2(point.y - latest.robot.y, point.x - latest.robot.x);
    return { frame: ground.frame, pose: compose(inverse(ground.pose), { ...point, theta }) };
  }
}

function Entry({ name, reason, onClick }: { name: string; reason: string | null; onClick: () => void }) {
  return (
    <Menu.Item disabled={reason !== null} onClick={onClick}>
      {name}
      {reason !== null && (
        <Text size="xs" maw={260} component="div">
          {reason}
        </Text>
      )}
    </Menu.Item>
  );
}

/** Why the robot cannot be asked to dock now; null where it can. */
function useWhyNotDock(): string | null {
  const live = useLive();
  const server = useTopic("actionServer");
  const stopped = useTopicPart("stop", ({ latched }) => latched);
  const goal = currentGoal(useTopic("courses"));
  const running = goal !== null && !isTerminal(goal.status) ? goal : null;
  return whyNotSend("dock", { live, stopped, running, sending: false, server });
}

interface Target {
  /** The frame of the map. */
  frame: string;
  pose: Pose;
}

interface Navigator {
  action: ActionInfo;
  /** Why it cannot be used now; null where it can. */
  reason: string | null;
}

/** The action that drives the robot to a pose, as nav2 has it; null where there is none. */
function useNavigator(): Navigator | null {
  const { http } = useFleet();
  const { robot } = useServices();
  const live = useLive();
  const stopped = useTopicPart("stop", ({ latched }) => latched);
  const namespace = useFleetPart("robots", (robots) => robot ?? defaultRobot(robots));
  const { data } = useAnswer({
    queryKey: ["navigators"],
    queryFn: () =>
      createActionsApi(http)
        .list()
        .then((actions) => actions ?? []),
    refetchInterval: LOOK_EVERY_MS,
    enabled: live,
  });
  const action = data?.find(
    ({ action_name, action_type }) =>
      action_name === `${namespace === "/" ? "" : namespace}/${NAVIGATE}` &&
      action_type.endsWith("/NavigateToPose"),
  );
  if (action === undefined) return null;
  const reason =
    whyForbidden("POST /actions/{name}/goals") ??
    (!live
      ? NOT_CONNECTED
      : stopped
        ? "The robot is stopped. Release the stop first."
        : action.available
          ? action.hint
          : "No action server for this action. Start it first.");
  return { action, reason };
}

interface DriveDialogProps {
  navigator: Navigator;
  /** Null where nothing is asked. */
  target: Target | null;
  onClose: () => void;
}

/** Always asks, and names the pose: a press on a map is soon a little off. */
function DriveDialog({ navigator: { action, reason }, target, onClose }: DriveDialogProps) {
  const { http } = useFleet();
  const { robot } = useServices();
  const naming = useNaming();
  const send = useCommand(async ({ frame, pose }: Target) => {
    await createActionsApi(http).send(action.action_name, JSON.stringify(poseGoal(frame, pose)));
    notifications.show({
      role: "status",
      title: "Drive here: accepted",
      message: "Goals has it, with its feedback.",
      autoClose: 6000,
      closeButtonProps: { "aria-label": "Dismiss" },
    });
    onClose();
  });
  const close = () => {
    send.reset();
    onClose();
  };
  return (
    <Dialog
      opened={target !== null}
      onClose={close}
      title={`Drive ${robot === null ? "the robot" : naming.fullNameOf(robot)} here?`}
    >
      <Stack gap="md">
        <Text size="sm">
          It drives by itself to <strong>{target && describePose(target.pose)}</strong> in the frame{" "}
          {target?.frame}. Check first that the area is clear.
        </Text>
        <CommandErrorAlert command="Drive here" error={send.error} onClose={send.reset} />
        <QuestionBar
          keep="Leave it where it is"
          onKeep={close}
          go="Drive here"
          onGo={() => target !== null && send.mutate(target)}
          reason={send.isPending ? "A goal was sent. The action server has not answered yet." : reason}
        />
      </Stack>
    </Dialog>
  );
}

/** A goal of nav2_msgs/NavigateToPose. */
export function poseGoal(frame: string, { x, y, theta }: Pose) {
  return {
    pose: {
      header: { frame_id: frame },
      pose: {
        position: { x, y, z: 0 },
        orientation: { x: 0, y: 0, z: Math.sin(theta / 2), w: Math.cos(theta / 2) },
      },
    },
  };
}
