import {
  NativeSelect,
  SegmentedControl,
  Switch,
  Text,
  Textarea,
  TextInput,
  VisuallyHidden,
} from "@mantine/core";
import { convertBytes, countBytes, splitNumbers } from "../form/numbers";
import type { Bytes, BytesShape, FloatShape, IntegerShape, NumbersShape, TextShape } from "../form/shapes";
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
function unitSection(unit: string | null) {
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

/** The number of lines that a text of numbers needs, roughly. */
function rowsFor(text: string): number {
  return Math.max(1, Math.min(8, Math.ceil(text.length / 60)));
}

/** A field's name, as ROS has it, and its unit for those who do not see it at the end of the input. */
function Label({ name, unit }: { name: string; unit: string | null }) {
  return (
    <>
      {name}
      {unit !== null && <VisuallyHidden> in {unit}</VisuallyHidden>}
    </>
  );
}

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

interface BytesFieldProps extends InputProps<Bytes> {
  shape: BytesShape;
}

/** `uint8[]`, as numbers or as base64. */
export function BytesField({ path, label, description, value, shape, optional }: BytesFieldProps) {
  const { ref, error, set } = useField<HTMLTextAreaElement>(path);
  const count = countBytes(value);
  return (
    <div className={classes.wide}>
      <Textarea
        ref={ref}
        label={label}
        description={
          <>
            {description}
            {description !== null && <br />}
            {count ?? "?"} of {lengthWords(shape, "byte") || "any number of bytes"}
            {value.encoding === "numbers" ? ": 0 to 255, between commas or spaces" : ", as base64"}
          </>
        }
        error={error}
        rows={rowsFor(value.text)}
        autoComplete="off"
        spellCheck={false}
        placeholder={optional ? "as in the definition" : undefined}
        inputWrapperOrder={ORDER}
        classNames={{ input: classes.numbers, description: classes.description }}
        value={value.text}
        onChange={(event) => set({ ...value, text: event.currentTarget.value })}
      />
      <SegmentedControl
        size="xs"
        mt={4}
        aria-label={`${label} as`}
        value={value.encoding}
        onChange={(encoding) => set(convertBytes(value, encoding as Bytes["encoding"]))}
        data={[
          { label: "Numbers", value: "numbers" },
          { label: "Base64", value: "base64" },
        ]}
      />
    </div>
  );
}
