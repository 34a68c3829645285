import { NumberInput, SegmentedControl, Text, TextInput } from "@mantine/core";
import { MAX_WAIT_S, type WaitKind } from "./draft";
import classes from "./missions.module.css";
import { type FieldsProps, Refused } from "./StepFields";
import { secondsWords } from "./words";
import { errorAt } from "./wrong";

const WAITS: { value: WaitKind; label: string }[] = [
  { value: "seconds", label: "Seconds" },
  { value: "until", label: "Time" },
  { value: "battery", label: "Battery" },
  { value: "person", label: "Person" },
];

/** What to wait for. */
export function WaitFields({ step, errors, set }: FieldsProps) {
  const until = errorAt(errors, "wait.until");
  return (
    <>
      <SegmentedControl
        aria-label="Wait for"
        data={WAITS}
        value={step.wait}
        onChange={(wait) => set({ wait: wait as WaitKind }, "wait")}
        className={classes.kinds ?? ""}
      />
      {step.wait === "seconds" && (
        <div className={classes.fields}>
          <NumberInput
            label="Wait for"
            suffix=" s"
            min={0}
            max={MAX_WAIT_S}
            clampBehavior="none"
            value={step.seconds}
            error={errorAt(errors, "wait.seconds")}
            description={
              typeof step.seconds === "number" && step.seconds >= 60 ? secondsWords(step.seconds) : undefined
            }
            onChange={(seconds) => set({ seconds }, "wait")}
          />
        </div>
      )}
      {step.wait === "until" && (
        <div className={classes.fields}>
          <TextInput
            label="Day"
            type="date"
            value={step.day}
            error={until}
            onChange={(event) => set({ day: event.currentTarget.value }, "wait")}
          />
          <TextInput
            label="Time"
            placeholder="06:00"
            maxLength={5}
            value={step.clock}
            error={until !== undefined}
            onChange={(event) => set({ clock: event.currentTarget.value }, "wait")}
          />
        </div>
      )}
      {step.wait === "battery" && (
        <div className={classes.fields}>
          <NumberInput
            label="Until the battery has"
            suffix=" %"
            min={0.1}
            max={100}
            step={5}
            decimalScale={1}
            clampBehavior="none"
            value={step.charge}
            error={errorAt(errors, "wait.battery")}
            onChange={(charge) => set({ charge }, "wait")}
          />
        </div>
      )}
      {step.wait === "person" && (
        <Text size="sm" c="dimmed">
          The mission is held until someone presses Continue.
        </Text>
      )}
      {errorAt(errors, "wait") !== undefined && errors.some(({ path }) => path === "wait") && (
        <Refused errors={errors.filter(({ path }) => path === "wait")} where="wait" />
      )}
    </>
  );
}
