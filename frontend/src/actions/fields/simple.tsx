import { Switch, Text, Textarea, TextInput, VisuallyHidden } from "@mantine/core";
import { splitNumbers } from "../form/numbers";
import type { FloatShape, IntegerShape, NumbersShape, TextShape } from "../form/shapes";
import { lengthWords } from "../form/write";
import { type InputProps, ORDER, useField } from "./context";
import classes from "./fields.module.css";

export function SwitchField({ path, label, description, value }: InputProps<boolean>) {
  const { ref, error, set } = useField<HTMLInputElement>(path);
  return (
    <Switch
      ref={ref}
      className={classes.switch}
      label={label}
      description={description}
      error={error}
      checked={value}
      onChange={(event) => set(event.currentTarget.checked)}
    />
  );
}

interface NumberFieldProps extends InputProps<string> {
  shape: IntegerShape | FloatShape;
}

export function NumberField({ path, label, description, unit, value, shape }: NumberFieldProps) {
  const { ref, error, set } = useField<HTMLInputElement>(path);
  return (
    <TextInput
      ref={ref}
      label={<Label name={label} unit={unit} />}
      description={description}
      error={error}
      inputMode={shape.kind === "integer" ? "numeric" : "decimal"}
      autoComplete="off"
      placeholder={shape.kind === "float" && shape.unset ? "not measured" : undefined}
      inputWrapperOrder={ORDER}
      classNames={{ input: "tabular", description: classes.description }}
      value={value}
      onChange={(event) => set(event.currentTarget.value)}
      {...unitSection(unit)}
    />
  );
}

/** The unit at the end of an input. */
export function unitSection(unit: string | null) {
  if (unit === null) return {};
  return {
    rightSection: (
      <Text size="sm" c="dimmed" aria-hidden="true">
        {unit}
      </Text>
    ),
    rightSectionWidth: `${unit.length + 2}ch`,
    rightSectionPointerEvents: "none" as const,
  };
}

interface TextFieldProps extends InputProps<string> {
  shape: TextShape;
}

/** Grows with its lines; a line break is a part of the text. */
export function TextField({ path, label, description, value }: TextFieldProps) {
  const { ref, error, set } = useField<HTMLTextAreaElement>(path);
  return (
    <Textarea
      ref={ref}
      label={label}
      description={description}
      error={error}
      rows={Math.min(8, value.split("\n").length)}
      autoComplete="off"
      spellCheck={false}
      inputWrapperOrder={ORDER}
      classNames={{ input: classes.text, description: classes.description }}
      value={value}
      onChange={(event) => set(event.currentTarget.value)}
    />
  );
}

interface NumbersFieldProps extends InputProps<string> {
  shape: NumbersShape;
}

/** An array of numbers as one text: quicker to fill in, and to paste into, than an input for each. */
export function NumbersField({ path, label, description, unit, value, shape, optional }: NumbersFieldProps) {
  const { ref, error, set } = useField<HTMLTextAreaElement>(path);
  const count = splitNumbers(value).length;
  return (
    <Textarea
      ref={ref}
      label={<Label name={label} unit={unit} />}
      description={
        <>
          {description}
          {description !== null && <br />}
          {count} of {lengthWords(shape, "number") || "any number of them"}, between commas or spaces
          {shape.item.kind === "float" && "; NaN for not measured"}
        </>
      }
      error={error}
      rows={rowsFor(value)}
      autoComplete="off"
      spellCheck={false}
      placeholder={optional ? "as in the definition" : undefined}
      inputWrapperOrder={ORDER}
      classNames={{ root: classes.wide, input: classes.numbers, description: classes.description }}
      value={value}
      onChange={(event) => set(event.currentTarget.value)}
      {...unitSection(unit)}
    />
  );
}

/** As many lines as a text of numbers needs, more or less. */
export function rowsFor(text: string): number {
  return Math.max(1, Math.min(8, Math.ceil(text.length / 60)));
}

/** A field's name, as ROS has it, and its unit for those who do not see it at the end of the input. */
export function Label({ name, unit }: { name: string; unit: string | null }) {
  return (
    <>
      {name}
      {unit !== null && <VisuallyHidden> in {unit}</VisuallyHidden>}
    </>
  );
}
