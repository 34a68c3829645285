import { NativeSelect, NumberInput, SimpleGrid, Switch, TextInput } from "@mantine/core";
import { type BatteryForm, parseCells } from "./form";
import { HEALTH_WORDS, STATUS_WORDS, TECHNOLOGY_WORDS } from "./words";

interface FieldsProps {
  form: BatteryForm;
  onChange: (change: Partial<BatteryForm>) => void;
}

type Floats = "percent" | "voltage" | "current" | "temperature" | "charge" | "capacity" | "design_capacity";
type Choices = "power_supply_status" | "power_supply_health" | "power_supply_technology";
type Texts = "location" | "serial_number" | "frame_id" | "cell_voltage" | "cell_temperature";

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

/** The rest of sensor_msgs/BatteryState. */
export function MoreFields(props: FieldsProps) {
  return (
    <SimpleGrid cols={{ base: 1, xs: 2 }} spacing="sm">
      <FloatField
        {...props}
        field="current"
        label="Current (A)"
        description="Negative when discharging"
        step={0.1}
      />
      <FloatField
        {...props}
        field="temperature"
        label="Temperature (°C)"
        description="Of the battery"
        step={1}
      />
      <FloatField {...props} field="charge" label="Charge (Ah)" step={0.1} />
      <FloatField {...props} field="capacity" label="Capacity (Ah)" step={0.1} />
      <FloatField {...props} field="design_capacity" label="Design capacity (Ah)" step={0.1} />
      <ChoiceField {...props} field="power_supply_health" label="Health" words={HEALTH_WORDS} />
      <ChoiceField {...props} field="power_supply_technology" label="Technology" words={TECHNOLOGY_WORDS} />
      <TextField {...props} field="cell_voltage" label="Cell voltages (V)" cells />
      <TextField {...props} field="cell_temperature" label="Cell temperatures (°C)" cells />
      <TextField {...props} field="location" label="Location" />
      <TextField {...props} field="serial_number" label="Serial number" />
      <TextField {...props} field="frame_id" label="Frame id (header)" />
      <Switch
        label="Battery is present"
        checked={props.form.present}
        onChange={(event) => props.onChange({ present: event.currentTarget.checked })}
      />
    </SimpleGrid>
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

function FloatField({ form, onChange, field, label, ...limits }: FloatFieldProps) {
  return (
    <NumberInput
      label={label}
      placeholder="not measured"
      value={form[field]}
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

function ChoiceField({ form, onChange, field, label, words }: ChoiceFieldProps) {
  return (
    <NativeSelect
      label={label}
      value={form[field]}
      onChange={(event) => onChange({ [field]: Number(event.currentTarget.value) })}
      data={words.map((word, value) => ({ label: word, value: String(value) }))}
    />
  );
}

interface TextFieldProps extends FieldsProps {
  field: Texts;
  label: string;
  /** Whether it is a list of numbers. */
  cells?: boolean;
}

function TextField({ form, onChange, field, label, cells = false }: TextFieldProps) {
  const wrong = cells && parseCells(form[field]) === null;
  return (
    <TextInput
      label={label}
      placeholder={cells ? "3.9, 3.8, - (not measured)" : undefined}
      value={form[field]}
      maxLength={200}
      error={wrong ? "Numbers between commas, with a dash for a cell that is not measured" : undefined}
      onChange={(event) => onChange({ [field]: event.currentTarget.value })}
    />
  );
}
