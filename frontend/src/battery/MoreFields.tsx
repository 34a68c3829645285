import { Button, Group, Input, NumberInput, SimpleGrid, Switch, Text, TextInput } from "@mantine/core";
import { ChoiceField, type FieldsProps, FloatField } from "./BatteryFields";
import classes from "./battery.module.css";
import { isNumber, type NumberInputValue } from "./form";
import { HEALTH_WORDS, TECHNOLOGY_WORDS } from "./words";

/** The rest of sensor_msgs/BatteryState. */
export default function MoreFields(props: FieldsProps) {
  return (
    <SimpleGrid cols={{ base: 1, xs: 2, md: 4 }} spacing="sm">
      <FloatField {...props} field="current" label="Current (A)" step={0.1} />
      <FloatField {...props} field="temperature" label="Temperature (°C)" step={1} />
      <FloatField {...props} field="charge" label="Charge (Ah)" step={0.1} />
      <FloatField {...props} field="capacity" label="Capacity (Ah)" step={0.1} />
      <FloatField {...props} field="design_capacity" label="Design capacity (Ah)" step={0.1} />
      <ChoiceField {...props} field="power_supply_health" label="Health" words={HEALTH_WORDS} />
      <ChoiceField {...props} field="power_supply_technology" label="Technology" words={TECHNOLOGY_WORDS} />
      <Switch
        label="Battery is present"
        checked={props.form.present}
        onChange={(event) => props.onChange({ present: event.currentTarget.checked })}
        style={{ alignSelf: "end", paddingBottom: "0.5rem" }}
      />
      <CellsField {...props} field="cell_voltage" label="Cell voltages (V)" step={0.1} />
      <CellsField {...props} field="cell_temperature" label="Cell temperatures (°C)" step={1} />
      <TextField {...props} field="location" label="Location" />
      <TextField {...props} field="serial_number" label="Serial number" />
      <TextField {...props} field="frame_id" label="Frame id (header)" />
      <Text size="sm" c="dimmed" style={{ alignSelf: "end" }}>
        Current is negative while the battery discharges. The header's stamp is the time of publishing.
      </Text>
    </SimpleGrid>
  );
}

interface TextFieldProps extends FieldsProps {
  field: "location" | "serial_number" | "frame_id";
  label: string;
}

function TextField({ form, onChange, field, label }: TextFieldProps) {
  return (
    <TextInput
      label={label}
      value={form[field]}
      maxLength={200}
      onChange={(event) => onChange({ [field]: event.currentTarget.value })}
    />
  );
}

interface CellsFieldProps extends FieldsProps {
  field: "cell_voltage" | "cell_temperature";
  label: string;
  step: number;
}

/** A value for each cell of a battery; an empty one is not measured. */
function CellsField({ form, onChange, field, label, step }: CellsFieldProps) {
  const cells = form[field];
  const change = (next: NumberInputValue[]) => onChange({ [field]: next });
  return (
    <fieldset className={classes.cells}>
      <Input.Label component="legend">{label}</Input.Label>
      {cells.map((value, index) => (
        <NumberInput
          // biome-ignore lint/suspicious/noArrayIndexKey: a cell is known by its place
          key={index}
          aria-label={`${label}, cell ${index + 1}`}
          placeholder="not measured"
          step={step}
          value={value}
          error={isNumber(value) ? undefined : "Not a number"}
          onChange={(next) => change(cells.with(index, next))}
        />
      ))}
      <Group gap="xs">
        <Button variant="default" size="xs" onClick={() => change([...cells, cells.at(-1) ?? ""])}>
          Add a cell
        </Button>
        {cells.length > 0 && (
          <Button variant="default" size="xs" onClick={() => change(cells.slice(0, -1))}>
            Remove the last
          </Button>
        )}
      </Group>
    </fieldset>
  );
}
