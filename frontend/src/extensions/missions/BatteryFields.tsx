import { Checkbox, NumberInput } from "@mantine/core";
import { type BatteryDraft, USUAL_BATTERY } from "./draft";
import classes from "./missions.module.css";
import { errorAt, type Wrong } from "./wrong";

interface BatteryFieldsProps {
  battery: BatteryDraft | null;
  errors: readonly Wrong[];
  onChange: (battery: BatteryDraft | null) => void;
}

/** Whether the robot returns to charge, below which charge, and until when. */
export function BatteryFields({ battery, errors, onChange }: BatteryFieldsProps) {
  return (
    <>
      <Checkbox
        label="Return to charge when the battery is low"
        description="The robot finishes its step, docks, charges, and goes on where it was."
        checked={battery !== null}
        onChange={(event) => onChange(event.currentTarget.checked ? USUAL_BATTERY : null)}
      />
      {battery !== null && (
        <div className={classes.fields}>
          <NumberInput
            label="Returns below"
            suffix=" %"
            min={1}
            max={95}
            clampBehavior="none"
            value={battery.below}
            error={errorAt(errors, "battery.below")}
            onChange={(below) => onChange({ ...battery, below })}
          />
          <NumberInput
            label="Charges to"
            suffix=" %"
            min={1}
            max={100}
            clampBehavior="none"
            value={battery.chargeTo}
            error={errorAt(errors, "battery.charge_to")}
            onChange={(chargeTo) => onChange({ ...battery, chargeTo })}
          />
        </div>
      )}
    </>
  );
}
