import { SegmentedControl } from "@mantine/core";
import { formatExact, formatPreciseTime, formatTime } from "./time";
import { setZone, useZone, type Zone } from "./zone";

/** A moment in the zone that is shown, `precise` to the millisecond; exact on hover. */
export function Time({ value, precise = false }: { value: string | number; precise?: boolean }) {
  useZone();
  const ms = typeof value === "number" ? value : Date.parse(value);
  return (
    <time dateTime={new Date(ms).toISOString()} title={formatExact(ms)}>
      {precise ? formatPreciseTime(ms) : formatTime(ms)}
    </time>
  );
}

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
