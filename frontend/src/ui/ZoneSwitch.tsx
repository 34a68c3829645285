import { SegmentedControl } from "@mantine/core";
import { setZone, useZone, type Zone } from "./zone";

const ZONES: { value: Zone; label: string }[] = [
  { value: "local", label: "Local" },
  { value: "utc", label: "UTC" },
];

/** Whether times are local or UTC, on every page. */
export function ZoneSwitch() {
  const zone = useZone();
  return (
    <SegmentedControl
      aria-label="Time zone of every page"
      data={ZONES}
      value={zone}
      onChange={(next) => setZone(next as Zone)}
      w="fit-content"
    />
  );
}
