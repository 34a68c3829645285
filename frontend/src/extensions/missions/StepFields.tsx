import { NativeSelect, Text } from "@mantine/core";
import { useFleet, useFleetPart } from "../../fleet/context";
import { useAnswer } from "../../ui/requests";
import type { StepDraft } from "./draft";
import classes from "./missions.module.css";
import { errorAt, type Wrong } from "./wrong";

/** Changes a step. */
export type Edit = (edit: (before: StepDraft) => StepDraft) => void;

export interface FieldsProps {
  step: StepDraft;
  errors: readonly Wrong[];
  set: (part: Partial<StepDraft>, ...paths: string[]) => void;
}

/** What the gateway has refused of something that has no field here. */
export function Refused({ errors, where }: { errors: readonly Wrong[]; where: string }) {
  const error = errorAt(errors, where);
  if (error === undefined) return null;
  return (
    <Text size="sm" c="var(--mantine-color-error)">
      {error}
    </Text>
  );
}

/** Which dock: the default one, or one that the robot's docking server knows by name. */
export function DockFields({ step, robot, errors, set }: FieldsProps & { robot: string }) {
  const { gatewayOf } = useFleet();
  const available = useFleetPart("robots", (robots) => robots.get(robot)?.dock?.available === true);
  const { data } = useAnswer({
    queryKey: ["docks of", robot],
    queryFn: () => gatewayOf(robot).docks(),
    enabled: available,
  });
  const names = data?.docks.map(({ dock_id }) => dock_id) ?? [];
  const all = step.dock === "" || names.includes(step.dock) ? names : [...names, step.dock];
  const standard = data?.default ?? null;
  if (all.length === 0)
    return (
      <>
        <Text size="sm" c="dimmed">
          At the robot's dock.
        </Text>
        <Refused errors={errors} where="dock" />
      </>
    );
  return (
    <div className={classes.fields}>
      <NativeSelect
        label="Dock at"
        value={step.dock}
        error={errorAt(errors, "dock")}
        onChange={(event) => set({ dock: event.currentTarget.value }, "dock")}
        data={[
          { value: "", label: standard === null ? "The default dock" : `The default dock (${standard})` },
          ...all.map((name) => ({ value: name, label: name })),
        ]}
      />
    </div>
  );
}
