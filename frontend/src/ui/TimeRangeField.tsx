import { Group, SegmentedControl, TextInput } from "@mantine/core";
import { useEffect, useRef } from "react";
import { ZoneSwitch } from "./Time";
import classes from "./TimeRangeField.module.css";
import { clockOf, dayOf, timeAt } from "./time";
import { ANY_TIME, LASTS, type Last, ownDates, type TimeRange } from "./timeRange";
import { useZone } from "./zone";

const [ANY, OWN] = ["any", "own"];

interface TimeRangeFieldProps {
  value: TimeRange;
  onChange: (range: TimeRange) => void;
  /** Whether it may be any time. */
  any?: boolean;
  /** In the gateway's time (ms). */
  now: () => number;
}

/** Which part of time a page shows, and in which zone. */
export function TimeRangeField({ value, onChange, any = false, now }: TimeRangeFieldProps) {
  const { last, since, until } = value;
  const chosen = last ?? (since === null && until === null && any ? ANY : OWN);
  const choose = (choice: string) => {
    if (choice === ANY) onChange(ANY_TIME);
    else if (choice === OWN) onChange(ownDates(value, now()));
    else onChange({ ...ANY_TIME, last: choice as Last });
  };
  return (
    <Group gap="xs">
      <SegmentedControl
        aria-label="Time"
        classNames={{ label: classes.choice ?? "" }}
        data={[
          ...(any ? [{ value: ANY, label: "Any" }] : []),
          ...Object.entries(LASTS).map(([value, label]) => ({ value, label })),
          { value: OWN, label: "Dates" },
        ]}
        value={chosen}
        onChange={choose}
      />
      {chosen === OWN && (
        <>
          <MomentInput label="From" time={since} onTime={(time) => onChange({ ...value, since: time })} />
          <MomentInput
            label="Until"
            end
            time={until}
            onTime={(time) => onChange({ ...value, until: time })}
          />
        </>
      )}
      <ZoneSwitch />
    </Group>
  );
}

interface MomentInputProps {
  label: string;
  /** Whether it is an end: midnight is `24:00` of the day before. */
  end?: boolean;
  time: string | null;
  onTime: (time: string | null) => void;
}

/** A day and a clock. What is typed is kept to itself until it is a time. */
function MomentInput({ label, end = false, time, onTime }: MomentInputProps) {
  useZone();
  const shown = time === null ? { day: "", clock: end ? "24:00" : "00:00" } : parts(Date.parse(time), end);
  const day = useShown(shown.day);
  const clock = useShown(shown.clock);
  const read = () => {
    const ms = timeAt(day.current?.value ?? "", clock.current?.value ?? "");
    if (ms !== null) onTime(new Date(ms).toISOString());
  };
  return (
    <Group gap={4} wrap="nowrap" role="group" aria-label={label}>
      <span aria-hidden="true" className={classes.label}>
        {label}
      </span>
      <TextInput
        ref={day}
        type="date"
        aria-label={`${label}, day`}
        defaultValue={shown.day}
        onChange={read}
        onBlur={(event) => event.currentTarget.value === "" && time !== null && onTime(null)}
      />
      <TextInput
        ref={clock}
        aria-label={`${label}, time of day`}
        placeholder="00:00"
        inputMode="numeric"
        maxLength={5}
        className={classes.clock ?? ""}
        defaultValue={shown.clock}
        onChange={read}
        onBlur={(event) => {
          event.currentTarget.value = shown.clock;
        }}
      />
    </Group>
  );
}

function parts(ms: number, end: boolean): { day: string; clock: string } {
  const clock = clockOf(ms);
  return end && clock === "00:00" ? { day: dayOf(ms, -1), clock: "24:00" } : { day: dayOf(ms), clock };
}

/** An input that shows what it is given, but for while somebody types there. */
function useShown(text: string) {
  const input = useRef<HTMLInputElement>(null);
  useEffect(() => {
    if (input.current !== null && document.activeElement !== input.current) input.current.value = text;
  }, [text]);
  return input;
}
