import { formatExact, formatPreciseTime, formatTime } from "./time";
import { useZone } from "./zone";

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
