import { Button, Group, Input, NumberInput } from "@mantine/core";
import type { FieldsProps } from "./BatteryFields";
import classes from "./battery.module.css";
import { isNumber, type NumberInputValue } from "./form";

interface CellsFieldProps extends FieldsProps {
  field: "cell_voltage" | "cell_temperature";
  label: string;
  step: number;
}

/** A value for each cell of a battery; an empty one is not measured. */
export function CellsField({ form, onChange, field, label, step }: CellsFieldProps) {
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
