import { Textarea } from "@mantine/core";
import { ENTRY_BUTTON, ReasonButton } from "../../ui/ReasonButton";
import type { StepDraft } from "./draft";
import classes from "./missions.module.css";
import type { Edit, FieldsProps } from "./StepFields";
import { asFields, asJson } from "./written";
import { stepErrors } from "./wrong";

/** All of a step, as JSON. */
export function WrittenFields({ step, errors, set }: FieldsProps) {
  const wrong = errors.map(({ path, detail }) => (path === "" ? detail : `${path}: ${detail}`));
  return (
    <Textarea
      label="Step"
      description="JSON, with its options."
      rows={5}
      resize="vertical"
      spellCheck={false}
      classNames={{ input: classes.code ?? "" }}
      value={step.content}
      error={wrong.length === 0 ? undefined : wrong.join("; ")}
      onChange={(event) => set({ content: event.currentTarget.value, refused: [] })}
    />
  );
}

interface FormSwitchProps {
  step: StepDraft;
  /** In the gateway's time (ms). */
  now: number;
  onChange: Edit;
}

/** Shows a step as JSON, or with its fields again. */
export function FormSwitch({ step, now, onChange }: FormSwitchProps) {
  const isJson = step.kind === "json";
  const ready = stepErrors(step, 0).length === 0;
  const other = isJson ? asFields(step, now) : asJson(step);
  const reason = !ready
    ? "Fill the step in first."
    : other === null
      ? "It has something that has no field."
      : null;
  return (
    <div>
      <ReasonButton {...ENTRY_BUTTON} reason={reason} onClick={() => other !== null && onChange(() => other)}>
        {isJson ? "Show its fields" : "Write as JSON"}
      </ReasonButton>
    </div>
  );
}
