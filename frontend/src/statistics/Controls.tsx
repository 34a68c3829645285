import { Group, NativeSelect, SegmentedControl, TextInput } from "@mantine/core";
import { useFleet } from "../fleet/context";
import { useRobotOptions } from "../fleet/useNaming";
import classes from "./statistics.module.css";
import { GROUPINGS, type Grouping, RANGES, type Range, type View, withRange } from "./view";

interface ControlsProps {
  view: View;
  onChange: (view: View) => void;
}

/** Which goals, and what they are grouped by. */
export function Controls({ view, onChange }: ControlsProps) {
  const { store } = useFleet();
  const change = (part: Partial<View>) => onChange({ ...view, ...part });
  const robots = useRobotOptions(view.robot);
  return (
    <section aria-label="Choose goals" className={classes.controls}>
      <SegmentedControl
        aria-label="Time"
        data={choices(RANGES)}
        value={view.range}
        onChange={(range) => onChange(withRange(view, range as Range, store.gatewayNow()))}
      />
      {view.range === "own" && (
        <Group gap="xs">
          <DayInput label="From" value={view.from} onDay={(from) => change({ from })} />
          <DayInput label="To" value={view.to} onDay={(to) => change({ to })} />
        </Group>
      )}
      <SegmentedControl
        aria-label="Group by"
        data={choices(GROUPINGS)}
        value={view.by}
        onChange={(by) => change({ by: by as Grouping })}
      />
      <NativeSelect
        aria-label="Robot"
        value={view.robot ?? ""}
        onChange={(event) => change({ robot: event.currentTarget.value || null })}
        data={[{ value: "", label: "All robots" }, ...robots]}
      />
    </section>
  );
}

interface DayInputProps {
  label: string;
  value: string | null;
  onDay: (day: string) => void;
}

/** An emptied or half typed date changes nothing. */
function DayInput({ label, value, onDay }: DayInputProps) {
  return (
    <TextInput
      type="date"
      aria-label={label}
      defaultValue={value ?? ""}
      onChange={(event) => event.currentTarget.value && onDay(event.currentTarget.value)}
    />
  );
}

function choices<Value extends string>(words: Record<Value, string>): { value: Value; label: string }[] {
  return (Object.keys(words) as Value[]).map((value) => ({ value, label: words[value] }));
}
