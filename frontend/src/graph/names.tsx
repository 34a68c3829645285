import { Code, Stack, Text, Title } from "@mantine/core";
import classes from "./graph.module.css";
import { type Kind, type Thing, thingId } from "./things";
import type { ChangeView } from "./view";

/** The ROS types of a thing; there is one where all is well. */
export function TypeNames({ types }: { types: readonly string[] }) {
  return (
    <div>
      <Text size="sm" c="dimmed">
        {types.length > 1 ? "Types" : "Type"}
      </Text>
      {types.map((type) => (
        <Code key={type} className={classes.type}>
          {type}
        </Code>
      ))}
    </div>
  );
}

interface ThingLinkProps extends Thing {
  change: ChangeView;
  current?: boolean;
}

/** The name of a thing, which shows its details. */
export function ThingLink({ kind, name, change, current = false }: ThingLinkProps) {
  return (
    <button
      type="button"
      className={classes.link}
      aria-current={current || undefined}
      data-thing={thingId({ kind, name })}
      onClick={() => change({ selected: { kind, name } })}
    >
      {name}
    </button>
  );
}

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
