import {
  MultiSelect,
  NativeSelect,
  type NativeSelectProps,
  SegmentedControl,
  SimpleGrid,
  Stack,
} from "@mantine/core";
import { useMemo } from "react";
import { useFleetTopic, useNaming } from "./context";
import type { RobotChoice } from "./robotChoice";

interface RobotFieldsProps {
  chosen: RobotChoice;
  /** What is wrong with the choice. */
  error: string | undefined;
  onChange: (part: Partial<RobotChoice>) => void;
}

/** Chooses all robots, or some by their names and groups. */
export function RobotFields({ chosen, error, onChange }: RobotFieldsProps) {
  const naming = useNaming();
  const known = useFleetTopic("robots").keys();
  const robots = naming.inOrder([...known, ...chosen.names]);
  const groups = [...new Set([...naming.groups(), ...chosen.groups])].sort();
  return (
    <Stack gap="sm">
      <SegmentedControl
        aria-label="Robots"
        data={[
          { value: "all", label: "All robots" },
          { value: "some", label: "Some robots" },
        ]}
        value={chosen.all ? "all" : "some"}
        onChange={(value) => onChange({ all: value === "all" })}
      />
      {!chosen.all && (
        <SimpleGrid cols={{ base: 1, xs: 2 }} spacing="sm">
          <MultiSelect
            label="Robots"
            searchable
            data={robots.map((name) => ({ value: name, label: naming.fullNameOf(name) }))}
            value={chosen.names}
            error={error}
            onChange={(names) => onChange({ names })}
          />
          <MultiSelect
            label="Groups"
            searchable
            data={groups}
            value={chosen.groups}
            onChange={(groups) => onChange({ groups })}
          />
        </SimpleGrid>
      )}
    </Stack>
  );
}

interface GroupSelectProps extends Pick<NativeSelectProps, "label" | "aria-label" | "className"> {
  group: string | null;
  onGroup: (group: string | null) => void;
}

/** Chooses a group of robots; nothing where no robot is in one. */
export function GroupSelect({ group, onGroup, ...props }: GroupSelectProps) {
  const naming = useNaming();
  const groups = useMemo(() => naming.groups(), [naming]);
  const known = group === null || groups.includes(group) ? groups : [...groups, group];
  if (known.length === 0) return null;
  return (
    <NativeSelect
      {...props}
      value={group ?? ""}
      onChange={(event) => onGroup(event.currentTarget.value || null)}
      data={[{ value: "", label: "All groups" }, ...known]}
    />
  );
}

interface RobotSelectProps extends Pick<NativeSelectProps, "label" | "aria-label"> {
  /** A namespace; null for all robots. */
  robot: string | null;
  onRobot: (robot: string | null) => void;
}

/** Chooses a robot by its namespace, also an unknown one that the address names. */
export function RobotSelect({ robot, onRobot, ...props }: RobotSelectProps) {
  const robots = useFleetTopic("robots");
  const naming = useNaming();
  const names = naming.inOrder([...robots.keys(), ...(robot === null ? [] : [robot])]);
  const options = names.map((name) => ({
    value: name,
    label: naming.besides(name) === null ? name : naming.fullNameOf(name),
  }));
  return (
    <NativeSelect
      {...props}
      value={robot ?? ""}
      onChange={(event) => onRobot(event.currentTarget.value || null)}
      data={[{ value: "", label: "All robots" }, ...options]}
    />
  );
}
