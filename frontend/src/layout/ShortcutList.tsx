import { Anchor, Group, Kbd, Stack, Switch, Text, TextInput, Title } from "@mantine/core";
import { Fragment, useState } from "react";
import { Link } from "react-router";
import { loginName, MAX_NAME, ownName, setOwnName } from "../access/who";
import { useMenu } from "../pages/pages";
import { TWICE_WITHIN_MS } from "../stop/keys";
import { ZoneSwitch } from "../ui/Time";
import classes from "./layout.module.css";
import { lettersOn, setLettersOn } from "./ShortcutsButton";

interface Shortcut {
  keys: readonly string[];
  what: string;
}

const EVERYWHERE: readonly Shortcut[] = [
  {
    keys: ["Esc", "Esc"],
    what: `Stop every robot: Escape twice within ${TWICE_WITHIN_MS / 1000} s`,
  },
  { keys: ["Ctrl", "Shift", "X"], what: "Stop every robot, also while you type" },
  { keys: ["Ctrl", "K"], what: "Search and commands: robots, pages, goals, actions" },
  { keys: ["Tab", "Enter"], what: "To the next control; press it" },
];

const letters = (menu: ReturnType<typeof useMenu>): readonly Shortcut[] => [
  { keys: ["?"], what: "This list" },
  { keys: ["/"], what: "Search on the page" },
  ...menu.map(({ letter, name }) => ({ keys: ["g", letter], what: `Go to ${name}` })),
];

const PICTURE: readonly Shortcut[] = [
  { keys: ["+", "−", "0"], what: "Closer, farther, all of it" },
  {
    keys: ["←", "↑", "→", "↓"],
    what: "Move a simulated robot, with Shift turn it; Enter places it. Without a simulator, or with Ctrl: move the picture",
  },
];

const PLOTS: readonly Shortcut[] = [
  { keys: ["←", "→"], what: "The crosshair; with Shift back and forth in time" },
  { keys: ["PgUp", "PgDn"], what: "As far back, or forth, as is shown" },
  { keys: ["+", "−", "0"], what: "Closer, farther, the last five minutes live" },
  { keys: ["Space"], what: "Pause, and go on" },
];

const GRAPH: readonly Shortcut[] = [
  { keys: ["←", "↑", "→", "↓"], what: "To the next node, topic or action in that direction" },
  { keys: ["Enter"], what: "Show its details" },
  { keys: ["+", "−", "0"], what: "Closer, farther, everything" },
];

/** Everything that keys do, the name of who presses them, and the zone of the times. */
export default function ShortcutList() {
  return (
    <Stack gap="md">
      <Shortcuts title="Everywhere" shortcuts={EVERYWHERE} />
      <Shortcuts title="One letter after the other" shortcuts={letters(useMenu())} />
      <LettersSwitch />
      <Shortcuts title="In the picture of a robot" shortcuts={PICTURE} />
      <Shortcuts title="In the plots of a battery" shortcuts={PLOTS} />
      <Shortcuts title="In the picture of the graph" shortcuts={GRAPH} />
      <NameField />
      <Group gap="sm">
        <Text size="sm">Times on every page:</Text>
        <ZoneSwitch />
      </Group>
      <Group gap="md">
        <Anchor component={Link} to="/ui/help" size="sm">
          Help
        </Anchor>
        <Anchor href="/docs" size="sm">
          API documentation
        </Anchor>
      </Group>
    </Stack>
  );
}

function Shortcuts({ title, shortcuts }: { title: string; shortcuts: readonly Shortcut[] }) {
  return (
    <div>
      <Title order={3} size="h5" mb={4}>
        {title}
      </Title>
      <dl className={classes.shortcuts}>
        {shortcuts.map(({ keys, what }) => (
          <Fragment key={what}>
            <dt>
              {keys.map((key, index) => (
                // biome-ignore lint/suspicious/noArrayIndexKey: the same key can be there twice
                <Kbd key={index} mr={4}>
                  {key}
                </Kbd>
              ))}
            </dt>
            <Text component="dd" size="sm">
              {what}
            </Text>
          </Fragment>
        ))}
      </dl>
    </div>
  );
}

function LettersSwitch() {
  const [on, setOn] = useState(lettersOn);
  return (
    <Switch
      label="Single-key shortcuts"
      description="Off where you speak to this computer, or press keys by mistake. Stop works either way."
      checked={on}
      onChange={(event) => {
        setOn(event.currentTarget.checked);
        setLettersOn(event.currentTarget.checked);
      }}
    />
  );
}

function NameField() {
  const [name, setName] = useState(ownName);
  if (loginName() !== null) return null;
  return (
    <TextInput
      label="Your name"
      description="Others read it where you stop a robot or acknowledge an alert. It is kept in this browser."
      autoComplete="name"
      maxLength={MAX_NAME}
      value={name}
      onChange={(event) => {
        setName(event.currentTarget.value);
        setOwnName(event.currentTarget.value);
      }}
    />
  );
}
