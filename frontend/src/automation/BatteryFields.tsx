import { NumberInput, SimpleGrid } from "@mantine/core";
import { type Draft, type DraftErrors, MAX_IDLE_S, MIN_IDLE_S } from "./draft";

export interface FieldsProps {
  draft: Draft;
  errors: DraftErrors;
  onChange: (part: Partial<Draft>) => void;
}

/** How low the battery has to be, and for how long the robot idle. */
export function BatteryFields({ draft, errors, onChange }: FieldsProps) {
  return (
    <SimpleGrid cols={{ base: 1, xs: 2 }} spacing="sm">
      <NumberInput
        label="Battery below"
        suffix=" %"
        min={0.1}
        max={100}
        step={5}
        decimalScale={1}
        value={draft.below}
        error={errors.below}
        onChange={(below) => onChange({ below })}
      />
      <NumberInput
        label="And idle for"
        suffix=" s"
        min={MIN_IDLE_S}
        max={MAX_IDLE_S}
        step={10}
        allowDecimal={false}
        value={draft.idleSeconds}
        error={errors.idleSeconds}
        onChange={(idleSeconds) => onChange({ idleSeconds })}
      />
    </SimpleGrid>
  );
}
