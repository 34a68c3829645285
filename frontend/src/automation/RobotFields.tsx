import { MultiSelect, SegmentedControl, SimpleGrid, Stack } from "@mantine/core";
import { useFleetTopic } from "../fleet/context";
import { useNaming } from "../fleet/useNaming";
import type { FieldsProps } from "./BatteryFields";

/** Which robots a rule is for. */
export function RobotFields({ draft, errors, onChange }: FieldsProps) {
  const naming = useNaming();
  const known = [...useFleetTopic("robots").keys()];
  const robots = [...new Set([...known, ...draft.names])].sort();
  const groups = [...new Set([...naming.groups(), ...draft.groups])].sort();
  return (
    <Stack gap="sm">
      <SegmentedControl
        aria-label="Robots"
        data={[
          { value: "all", label: "All robots" },
          { value: "some", label: "Some robots" },
        ]}
        value={draft.all ? "all" : "some"}
        onChange={(value) => onChange({ all: value === "all" })}
      />
      {!draft.all && (
        <SimpleGrid cols={{ base: 1, xs: 2 }} spacing="sm">
          <MultiSelect
            label="Robots"
            searchable
            data={robots.map((name) => ({ value: name, label: naming.fullNameOf(name) }))}
            value={draft.names}
            error={errors.names}
            onChange={(names) => onChange({ names })}
          />
          <MultiSelect
            label="Groups"
            searchable
            data={groups}
            value={draft.groups}
            onChange={(chosen) => onChange({ groups: chosen })}
          />
        </SimpleGrid>
      )}
    </Stack>
  );
}
