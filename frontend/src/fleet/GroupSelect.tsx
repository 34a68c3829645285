import { NativeSelect, type NativeSelectProps } from "@mantine/core";
import { useMemo } from "react";
import { useNaming } from "./useNaming";

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
