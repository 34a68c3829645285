import { formatExact, formatPreciseTime, formatTime } from "./time";

/** A moment in the reader's zone, `precise` to the millisecond; exact on hover. */
export function Time({ value, precise = false }: { value: string | number; precise?: boolean }) {
  const ms = typeof value === "number" ? value : Date.parse(value);
  return (
    <time dateTime={new Date(ms).toISOString()} title={formatExact(ms)}>
      {precise ? formatPreciseTime(ms) : formatTime(ms)}
    </time>
  );
}
