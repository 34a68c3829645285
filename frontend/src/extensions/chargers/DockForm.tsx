import { Button, Fieldset, Group, Stack, Text, TextInput } from "@mantine/core";
import { type FormEvent, useState } from "react";
import { NameInput, ownName, setOwnName } from "../../access/who";
import { LIMITS } from "../../api/limits.gen";
import { RobotFields } from "../../fleet/RobotFields";
import { ALL_ROBOTS, choiceBody, choiceError, type RobotChoice } from "../../fleet/robotChoice";
import { FromRobot, PoseFields } from "../../scene/PoseFields";
import { poseDraft, poseErrors, poseOf } from "../../scene/poseDraft";
import { SaveBar } from "../../ui/Dialog";
import { useDockCommands } from "./docks";
import type { SharedDock } from "./requests";
import { WaitingPlaces } from "./WaitingPlaces";
import { nameError } from "./words";

interface DockFormProps {
  /** Null for a new one. */
  dock: SharedDock | null;
  docks: readonly SharedDock[];
  onDone: () => void;
}

/** Shares a dock, or says which robots it fits, where it is, and where robots wait for it. */
export function DockForm({ dock, docks, onDone }: DockFormProps) {
  const { save } = useDockCommands();
  const [name, setName] = useState(dock?.dock_id ?? "");
  const [chosen, setChosen] = useState<RobotChoice>(dock?.robots ?? ALL_ROBOTS);
  const [pose, setPose] = useState(() => (dock?.pose ? poseDraft(dock.pose) : null));
  const [type, setType] = useState(dock?.type ?? "");
  const [places, setPlaces] = useState(dock?.waiting_places ?? []);
  const [by, setBy] = useState(ownName);
  const [tried, setTried] = useState(false);
  const taken = dock === null ? docks.map(({ dock_id }) => dock_id) : [];
  const errors = { name: nameError(name, taken), robots: choiceError(chosen) };
  const submit = (event: FormEvent) => {
    event.preventDefault();
    setTried(true);
    if (errors.name !== undefined || errors.robots !== undefined) return;
    if (pose !== null && Object.keys(poseErrors(pose)).length > 0) return;
    setOwnName(by.trim());
    const body = {
      robots: choiceBody(chosen),
      pose: pose === null ? null : poseOf(pose),
      type: type.trim() || null,
      waiting_places: places,
      by: by.trim() || null,
    };
    save.mutate({ id: name.trim(), body, base: dock }, { onSuccess: onDone });
  };
  return (
    <form onSubmit={submit} noValidate>
      <Stack gap="md">
        {dock === null && (
          <TextInput
            label="Name"
            description="By which the docking servers of the robots know it: their dock_id."
            placeholder="home_dock"
            maxLength={60}
            value={name}
            error={tried ? errors.name : undefined}
            onChange={(event) => setName(event.currentTarget.value)}
            data-autofocus
          />
        )}
        <RobotFields
          chosen={chosen}
          error={tried ? errors.robots : undefined}
          onChange={(part) => setChosen((before) => ({ ...before, ...part }))}
        />
        <Fieldset legend="Where it is">
          <Stack gap="sm">
            {pose !== null && (
              <PoseFields
                draft={pose}
                errors={tried ? poseErrors(pose) : {}}
                onChange={(part) => setPose({ ...pose, ...part })}
              />
            )}
            {pose === null && (
              <Text size="sm" c="dimmed">
                Drive or push a robot onto the dock, then take where it stands.
              </Text>
            )}
            <Group gap="sm" align="flex-end">
              <FromRobot onPose={setPose} />
              <Button variant="default" onClick={() => setPose(pose === null ? poseDraft(null) : null)}>
                {pose === null ? "Type it" : "Forget it"}
              </Button>
            </Group>
          </Stack>
        </Fieldset>
        <TextInput
          label="Type"
          description="At the docking servers: one of their dock_plugins. Empty if they have one at most."
          placeholder="wall_dock"
          maxLength={LIMITS["PUT /shared-docks/{dock_id}"].type.maxLength}
          value={type}
          onChange={(event) => setType(event.currentTarget.value)}
        />
        <WaitingPlaces places={places} onChange={setPlaces} />
        <NameInput value={by} description="Shown with the dock." onChange={setBy} />
        <SaveBar save={save} onCancel={onDone} />
      </Stack>
    </form>
  );
}
