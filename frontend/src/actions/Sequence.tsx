import { Text } from "@mantine/core";
import classes from "./actions.module.css";

/** Numbers that are shown; the newest of them. */
const MAX_SHOWN = 60;

/** An array of numbers that grows: the newest marked, where it still does. */
export function Sequence({
  name,
  numbers,
  growing,
}: {
  name: string;
  numbers: readonly number[];
  growing: boolean;
}) {
  const earlier = Math.max(0, numbers.length - MAX_SHOWN);
  return (
    <div>
      <Text size="sm" mb={4}>
        {name}{" "}
        <Text span c="dimmed" inherit>
          · {numbers.length} {numbers.length === 1 ? "number" : "numbers"}
          {earlier > 0 && `, the first ${earlier} not shown`}
        </Text>
      </Text>
      <ol
        className={classes.sequence}
        aria-label={name}
        data-growing={growing || undefined}
        start={earlier + 1}
      >
        {numbers.slice(earlier).map((number, index) => (
          // biome-ignore lint/suspicious/noArrayIndexKey: a number is known by its place alone
          <li key={earlier + index}>{number.toLocaleString()}</li>
        ))}
      </ol>
    </div>
  );
}
