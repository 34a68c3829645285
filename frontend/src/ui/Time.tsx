import { formatExact, formatTime } from "./time";

/** A moment in the reader's zone; exact on hover. */
export function Time({ value }: { value: string | number }) {
  const ms = typeof value === "number" ? value : Date.parse(value);
  return (
    <time dateTime={new Date(ms).toISOString()} title={formatExact(ms)}>
      {formatTime(ms)}
    </time>
  );
}
