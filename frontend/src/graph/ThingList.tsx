import { Stack, Text, Title } from "@mantine/core";
import classes from "./graph.module.css";
import { ThingLink } from "./ThingLink";
import type { Kind } from "./things";
import type { ChangeView } from "./useView";

interface ThingListProps {
  title: string;
  kind: Kind;
  names: readonly string[];
  /** What to say where there are none; nothing is shown at all without it. */
  absent?: string;
  change: ChangeView;
}

/** Names under a title, each of which leads on. */
export function ThingList({ title, kind, names, absent, change }: ThingListProps) {
  if (names.length === 0 && absent === undefined) return null;
  return (
    <Stack gap={4}>
      <Title order={3} size="h5">
        {title}
      </Title>
      {names.length === 0 ? (
        <Text size="sm" c="dimmed">
          {absent}
        </Text>
      ) : (
        <ul className={classes.names}>
          {names.map((name) => (
            <li key={name}>
              <ThingLink kind={kind} name={name} change={change} />
            </li>
          ))}
        </ul>
      )}
    </Stack>
  );
}
