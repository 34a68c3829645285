import { Checkbox, Group, Select, Stack, TagsInput } from "@mantine/core";
import { useMemo } from "react";
import { dayWords, type TimesErrors, type TimesOfDay, WEEKDAYS } from "./timesOfDay";

interface TimesOfDayFieldsProps {
  draft: TimesOfDay;
  errors: TimesErrors;
  /** How many times there may be. */
  maxTimes: number;
  onChange: (part: Partial<TimesOfDay>) => void;
}

/** At which times, on which days, and in which time zone. */
export function TimesOfDayFields({ draft, errors, maxTimes, onChange }: TimesOfDayFieldsProps) {
  const zones = useMemo(
    () => [...new Set([draft.timeZone, "UTC", ...Intl.supportedValuesOf("timeZone")])].sort(),
    [draft.timeZone],
  );
  return (
    <Stack gap="sm">
      <TagsInput
        label="Times"
        description="HH:MM; Enter adds one."
        maxTags={maxTimes}
        value={draft.times}
        error={errors.times}
        onChange={(times) => onChange({ times })}
        acceptValueOnBlur
      />
      <Checkbox.Group
        label="Days"
        value={draft.weekdays}
        error={errors.weekdays}
        onChange={(weekdays) => onChange({ weekdays })}
      >
        <Group gap="sm" mt={4}>
          {WEEKDAYS.map((day) => (
            <Checkbox key={day} value={day} label={dayWords(day)} />
          ))}
        </Group>
      </Checkbox.Group>
      <Select
        label="Time zone"
        searchable
        allowDeselect={false}
        limit={100}
        data={zones}
        value={draft.timeZone}
        onChange={(zone) => zone !== null && onChange({ timeZone: zone })}
      />
    </Stack>
  );
}
