import type { ActionServer, Verb } from "@dock-gateway/client";
import { Group, NativeSelect, SegmentedControl, Stack, Switch, Text } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { useId, useState } from "react";
import { CHARGING, FULL } from "../battery/words";
import { useNaming } from "../fleet/context";
import { useDocked } from "../fleet/robot";
import { whyNotCancel } from "../goal/words";
import { RobotStopButton, useStoppableAlone } from "../stop/StopButton";
import { useLive, useServices, useTopic, useTopicPart } from "../store/context";
import type { GoalCourse } from "../store/goals";
import { CommandErrorAlert } from "../ui/errors";
import { ReasonButton } from "../ui/ReasonButton";
import { useCommand } from "../ui/requests";
import classes from "./docking.module.css";
import { useDockList } from "./docks";
import { takesBatteryGoal, whyNotSend } from "./families";
import { MoveDialog, useAsking } from "./MoveDialog";

/** Dock, Undock, Cancel, and a Stop of this robot alone where there are others; each says why where it cannot be used. */
export function DockingControls({ running }: { running: GoalCourse | null }) {
  const { gateway, store } = useServices();
  const live = useLive();
  const servers = { dock: useTopic("actionServer"), undock: useTopic("undockServer") };
  const takesBattery = takesBatteryGoal(servers.dock);
  const stopped = useTopicPart("stop", ({ latched }) => latched);
  const alone = useStoppableAlone();
  const naming = useNaming();
  const asking = useAsking();
  const [asked, setAsked] = useState<Verb>("dock");
  const [open, question] = useDisclosure(false);
  const [target, setTarget] = useState(String(CHARGING));
  const targetId = useId();
  const docks = useDocks(servers.dock);
  // What makes sense now stands out.
  const docked = useDocked() === true;

  const dock = useCommand(async () =>
    store.addGoals([await gateway.dock(takesBattery ? Number(target) : null, docks.chosen)]),
  );
  const undock = useCommand(async () => store.addGoals([await gateway.undock()]));
  const cancel = useCommand(async (goal: GoalCourse) => store.addGoals([await gateway.cancel(goal.goal_id)]));
  const send = (verb: Verb) => {
    question.close();
    for (const command of [dock, undock, cancel]) command.reset();
    (verb === "dock" ? dock : undock).mutate();
  };
  const press = (verb: Verb) => {
    if (!asking.asks) return send(verb);
    setAsked(verb);
    question.open();
  };

  const sending = dock.isPending || undock.isPending;
  const whyNot = (verb: Verb) => whyNotSend(verb, { live, stopped, running, sending, server: servers[verb] });
  const cancelReason = whyNotCancel(live, running, cancel.isPending);
  const silent = whyNot("dock") === null && servers.dock?.answering === false;

  return (
    <Stack gap="sm">
      <Group gap="xs" className={classes.verbs}>
        <ReasonButton
          size="lg"
          variant={docked ? "light" : "filled"}
          reason={whyNot("dock")}
          aria-haspopup={asking.asks ? "dialog" : undefined}
          onClick={() => press("dock")}
        >
          Dock
        </ReasonButton>
        <ReasonButton
          size="lg"
          variant={docked ? "filled" : "light"}
          reason={whyNot("undock")}
          aria-haspopup={asking.asks ? "dialog" : undefined}
          onClick={() => press("undock")}
        >
          Undock
        </ReasonButton>
        <ReasonButton
          size="lg"
          variant="default"
          reason={cancelReason}
          onClick={() => running && cancel.mutate(running)}
        >
          Cancel
        </ReasonButton>
        {alone !== null && <RobotStopButton robot={alone} />}
      </Group>
      {docks.all.length > 1 && (
        <NativeSelect
          label="Dock to"
          className={classes.dock}
          value={docks.chosen}
          onChange={(event) => docks.choose(event.currentTarget.value)}
          data={docks.all.map((name) => ({
            value: name,
            label: name === docks.standard ? `${name} (default)` : name,
          }))}
        />
      )}
      {takesBattery && (
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
      )}
      <Switch
        label={asking.simulated ? "Confirm before moving (off in simulation)" : "Confirm before moving"}
        checked={asking.asks}
        disabled={asking.simulated}
        onChange={(event) => asking.change(event.currentTarget.checked)}
      />
      <div role="status">
        {silent && (
          <Text size="sm" fw={700}>
            The docking server is not responding: a goal may time out.
          </Text>
        )}
      </div>
      <CommandErrorAlert command="Dock" error={dock.error} onClose={dock.reset} />
      <CommandErrorAlert command="Undock" error={undock.error} onClose={undock.reset} />
      <CommandErrorAlert command="Cancel" error={cancel.error} onClose={cancel.reset} />
      <MoveDialog
        opened={open}
        verb={asked}
        robot={alone === null ? null : naming.fullNameOf(alone)}
        dock={docks.all.length > 1 ? docks.chosen : undefined}
        reason={whyNot(asked)}
        onMove={() => send(asked)}
        onClose={question.close}
      />
    </Stack>
  );
}

interface Docks {
  /** The names of all docks, the default one first; none where the docking server knows no docks by name. */
  all: string[];
  /** The dock that a goal without a name is for; null where that is not known. */
  standard: string | null;
  /** The dock to drive to; undefined where there are none. */
  chosen: string | undefined;
  choose: (name: string) => void;
}

/** The docks of a robot, and the one that is chosen: the default one unless the user has chosen another. */
function useDocks(server: ActionServer | null): Docks {
  const [wanted, choose] = useState<string | null>(null);
  const data = useDockList(server);
  const names = data?.docks.map((dock) => dock.dock_id) ?? [];
  const standard = data?.default ?? null;
  const first = names.find((name) => name === standard) ?? names[0];
  const all = first === undefined ? [] : [first, ...names.filter((name) => name !== first)];
  return { all, standard, chosen: all.find((name) => name === wanted) ?? first, choose };
}
