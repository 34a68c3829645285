import { NativeSelect, NumberInput } from "@mantine/core";
import { type BatteryForm, isNumber } from "./form";
import { STATUS_WORDS } from "./words";

export interface FieldsProps {
  form: BatteryForm;
  onChange: (change: Partial<BatteryForm>) => void;
}

type Floats = "percent" | "voltage" | "current" | "temperature" | "charge" | "capacity" | "design_capacity";
type Choices = "power_supply_status" | "power_supply_health" | "power_supply_technology";

/** The fields that matter most. */
export function MainFields(props: FieldsProps) {
  return (
    <>
      <FloatField {...props} field="percent" label="Percentage (%)" min={0} max={100} step={1} />
      <FloatField {...props} field="voltage" label="Voltage (V)" step={0.1} />
      <ChoiceField {...props} field="power_supply_status" label="Status" words={STATUS_WORDS} />
    </>
  );
}

interface FloatFieldProps extends FieldsProps {
  field: Floats;
  label: string;
  step: number;
  description?: string;
  min?: number;
  max?: number;
}

export function FloatField({ form, onChange, field, label, ...limits }: FloatFieldProps) {
  return (
    <NumberInput
      label={label}
      placeholder="not measured"
      value={form[field]}
      error={isNumber(form[field]) ? undefined : "Not a number"}
      onChange={(value) => onChange({ [field]: value })}
      {...limits}
    />
  );
}

interface ChoiceFieldProps extends FieldsProps {
  field: Choices;
  label: string;
  words: readonly string[];
}

export function ChoiceField({ form, onChange, field, label, words }: ChoiceFieldProps) {
  return (
    <NativeSelect
      label={label}
      value={form[field]}
      onChange={(event) => onChange({ [field]: Number(event.currentTarget.value) })}
      data={words.map((word, value) => ({ label: word, value: String(value) }))}
    />
  );
}
