import { Checkbox, NativeSelect, NumberInput, Text, TextInput } from "@mantine/core";
import { useState } from "react";
import {
  isBlock,
  isInterruptible,
  MAX_STEP_NAME,
  MAX_TIMEOUT_S,
  MAX_TRIES,
  MIN_TIMEOUT_S,
  MIN_TRIES,
  type StepDraft,
} from "./draft";
import classes from "./missions.module.css";
import type { FieldsProps } from "./StepFields";
import { optionWords } from "./words";
import { errorAt } from "./wrong";

const GO_TO = "go to ";

function policyOf(value: string): StepDraft["onFailure"] {
  if (value.startsWith(GO_TO)) return { go_to: value.slice(GO_TO.length) };
  return value === "next" ? "next" : "end";
}

/** A time limit, tries, what a failure means, and a name. */
export function Options({ step, later, errors, set }: FieldsProps & { later: readonly string[] }) {
  const { onFailure } = step;
  const target = typeof onFailure === "object" ? onFailure.go_to : null;
  const targets = target === null || later.includes(target) ? later : [...later, target];
  const wrong = ["name", "timeout_s", "tries", "on_failure", "interruptible"].some(
    (path) => errorAt(errors, path) !== undefined,
  );
  const [opened, setOpened] = useState(false);
  const words = optionWords({
    tries: Number(step.tries),
    timeout_s: step.timeout === "" ? null : Number(step.timeout),
    on_failure: step.onFailure,
    interruptible: isInterruptible(step.kind) && step.interruptible,
  });
  return (
    <details
      className={classes.fold}
      open={opened || wrong}
      onToggle={(event) => setOpened(event.currentTarget.open)}
    >
      <summary>
        Options
        {words !== "" && (
          <Text span size="sm" c="dimmed">
            : {words}
          </Text>
        )}
      </summary>
      {(opened || wrong) && (
        <div className={classes.fields}>
          {!isBlock(step.kind) && (
            <>
              <NumberInput
                label="Time limit"
                description="A goal that runs is canceled then. Empty: no limit."
                suffix=" s"
                min={MIN_TIMEOUT_S}
                max={MAX_TIMEOUT_S}
                clampBehavior="none"
                value={step.timeout}
                error={errorAt(errors, "timeout_s")}
                onChange={(timeout) => set({ timeout }, "timeout_s")}
              />
              <NumberInput
                label="Tries"
                description="Five seconds apart."
                min={MIN_TRIES}
                max={MAX_TRIES}
                clampBehavior="none"
                allowDecimal={false}
                value={step.tries}
                error={errorAt(errors, "tries")}
                onChange={(tries) => set({ tries }, "tries")}
              />
            </>
          )}
          <NativeSelect
            label="If it fails"
            description="After the last try."
            value={target === null ? String(onFailure) : GO_TO + target}
            error={errorAt(errors, "on_failure")}
            onChange={(event) => set({ onFailure: policyOf(event.currentTarget.value) }, "on_failure")}
            data={[
              { value: "end", label: "End the mission" },
              { value: "next", label: "Go on with the next step" },
              ...targets.map((name) => ({ value: GO_TO + name, label: `Go to ${name}` })),
            ]}
          />
          <TextInput
            label="Step name"
            description="Steps before it can go to it."
            maxLength={MAX_STEP_NAME}
            value={step.name}
            error={errorAt(errors, "name")}
            onChange={(event) => set({ name: event.currentTarget.value }, "name")}
          />
          {isInterruptible(step.kind) && (
            <Checkbox
              label="Leave it when the robot has to charge"
              description="Its goal is canceled, and the step begins again afterwards. Otherwise it is finished first."
              checked={step.interruptible}
              error={errorAt(errors, "interruptible")}
              onChange={(event) => set({ interruptible: event.currentTarget.checked }, "interruptible")}
            />
          )}
        </div>
      )}
    </details>
  );
}
