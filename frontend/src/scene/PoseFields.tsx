import { Alert, Button, Group, NativeSelect, NumberInput, SimpleGrid, Stack, TextInput } from "@mantine/core";
import { useState } from "react";
import { useFleetTopic, useNaming } from "../fleet/context";
import { namesThere } from "../fleet/words";
import type { PoseDraft, PoseErrors } from "./poseDraft";
import { robotPose } from "./robotPose";

interface PoseFieldsProps {
  draft: PoseDraft;
  errors: PoseErrors;
  onChange: (part: Partial<PoseDraft>) => void;
}

/** A pose, to type. */
export function PoseFields({ draft, errors, onChange }: PoseFieldsProps) {
  return (
    <SimpleGrid cols={{ base: 1, xs: 2 }} spacing="sm">
      <NumberInput label="X" suffix=" m" value={draft.x} error={errors.x} onChange={(x) => onChange({ x })} />
      <NumberInput label="Y" suffix=" m" value={draft.y} error={errors.y} onChange={(y) => onChange({ y })} />
      <NumberInput
        label="Heading"
        suffix="°"
        value={draft.heading}
        error={errors.heading}
        onChange={(heading) => onChange({ heading })}
      />
      <TextInput
        label="Frame"
        value={draft.frame}
        error={errors.frame}
        onChange={(event) => onChange({ frame: event.currentTarget.value })}
      />
    </SimpleGrid>
  );
}

interface FromRobotProps {
  /** What the button does, before `where it stands now`. */
  verb?: string;
  onPose: (pose: PoseDraft) => void;
}

/** Takes where a robot stands now. */
export function FromRobot({ verb = "Use", onPose }: FromRobotProps) {
  const naming = useNaming();
  const robots = useFleetTopic("robots");
  const names = naming.inOrder(namesThere(robots));
  const [chosen, choose] = useState<string | null>(null);
  const [state, setState] = useState<"idle" | "asking" | "unknown">("idle");
  const robot = chosen ?? names[0];
  if (robot === undefined) return null;
  const ask = async () => {
    setState("asking");
    const pose = await robotPose(robot);
    setState(pose === null ? "unknown" : "idle");
    if (pose !== null) onPose(pose);
  };
  return (
    <Stack gap="xs">
      <Group gap="sm" align="flex-end">
        {names.length > 1 && (
          <NativeSelect
            label="Robot"
            value={robot}
            onChange={(event) => choose(event.currentTarget.value)}
            data={names.map((name) => ({ value: name, label: naming.fullNameOf(name) }))}
          />
        )}
        <Button variant="default" loading={state === "asking"} onClick={() => void ask()}>
          {verb} where {names.length > 1 ? "it" : naming.nameOf(robot)} stands now
        </Button>
      </Group>
      {state === "unknown" && (
        <Alert color="orange" role="alert">
          Nobody knows where {naming.nameOf(robot)} is: it has no localization. Type the coordinates.
        </Alert>
      )}
    </Stack>
  );
}
