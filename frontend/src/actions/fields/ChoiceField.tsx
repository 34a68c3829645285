import { NativeSelect, TextInput } from "@mantine/core";
import type { IntegerShape } from "../form/shapes";
import { type InputProps, ORDER, useField } from "./context";
import classes from "./fields.module.css";
import { unitSection } from "./simple";

interface ChoiceFieldProps extends InputProps<string> {
  shape: IntegerShape;
}

const OTHER = "other";

/** One of a field's constants, or any other number, as ROS takes it. */
export function ChoiceField({ path, label, description, unit, value, shape }: ChoiceFieldProps) {
  const { ref, error, set } = useField<HTMLInputElement & HTMLSelectElement>(path);
  const chosen = shape.choices.find((choice) => String(choice.value) === value.trim());
  const other = chosen === undefined;
  return (
    <div className={classes.choice}>
      <NativeSelect
        ref={other ? undefined : ref}
        label={label}
        description={chosen?.description ?? description}
        error={other ? undefined : error}
        inputWrapperOrder={ORDER}
        classNames={{ description: classes.description }}
        value={other ? OTHER : String(chosen.value)}
        onChange={(event) => set(event.currentTarget.value === OTHER ? "" : event.currentTarget.value)}
        data={[
          ...shape.choices.map((choice) => ({
            value: String(choice.value),
            label: `${choice.name} (${choice.value})`,
          })),
          { value: OTHER, label: "another number …" },
        ]}
      />
      {other && (
        <TextInput
          ref={ref}
          aria-label={`${label}: another number`}
          placeholder={`${shape.low} to ${shape.high}`}
          error={error}
          inputMode="numeric"
          autoComplete="off"
          value={value}
          onChange={(event) => set(event.currentTarget.value)}
          {...unitSection(unit)}
        />
      )}
    </div>
  );
}
