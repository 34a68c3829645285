import { Stack, TextInput } from "@mantine/core";
import { type FormEvent, useState } from "react";
import { NameInput, ownName, setOwnName } from "../../access/who";
import { RobotFields } from "../../fleet/RobotFields";
import { ALL_ROBOTS, choiceBody, choiceError, type RobotChoice } from "../../fleet/robotChoice";
import { SaveBar } from "../../ui/Dialog";
import { useDockCommands } from "./docks";
import type { SharedDock } from "./requests";
import { nameError } from "./words";

interface DockFormProps {
  /** Null for a new one. */
  dock: SharedDock | null;
  docks: readonly SharedDock[];
  onDone: () => void;
}

/** Shares a dock, or says which robots it fits. */
export function DockForm({ dock, docks, onDone }: DockFormProps) {
  const { save } = useDockCommands();
  const [name, setName] = useState(dock?.dock_id ?? "");
  const [chosen, setChosen] = useState<RobotChoice>(dock?.robots ?? ALL_ROBOTS);
  const [by, setBy] = useState(ownName);
  const [tried, setTried] = useState(false);
  const taken = dock === null ? docks.map(({ dock_id }) => dock_id) : [];
  const errors = { name: nameError(name, taken), robots: choiceError(chosen) };
  const submit = (event: FormEvent) => {
    event.preventDefault();
    setTried(true);
    if (errors.name !== undefined || errors.robots !== undefined) return;
    setOwnName(by.trim());
    const body = { robots: choiceBody(chosen), pose: dock?.pose ?? null, by: by.trim() || null };
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
        <NameInput value={by} description="Shown with the dock." onChange={setBy} />
        <SaveBar save={save} onCancel={onDone} />
      </Stack>
    </form>
  );
}
