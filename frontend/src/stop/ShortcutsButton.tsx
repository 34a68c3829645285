import { ActionIcon, Kbd, Stack, Text, TextInput } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { type ReactNode, useState } from "react";
import { Dialog } from "../ui/Dialog";
import { TWICE_WITHIN_MS } from "./keys";
import classes from "./stop.module.css";
import { MAX_NAME, ownName, setOwnName } from "./who";

/** What the keyboard does, and the name that others read when this page stops the robot. */
export function ShortcutsButton() {
  const [opened, { open, close }] = useDisclosure(false);
  return (
    <>
      <ActionIcon
        variant="default"
        size="lg"
        aria-label="Keyboard and name"
        title="Keyboard and name"
        aria-haspopup="dialog"
        onClick={open}
      >
        <svg width="20" height="20" viewBox="0 0 24 24" aria-hidden="true" fill="currentColor">
          <path d="M4 5h16a2 2 0 0 1 2 2v10a2 2 0 0 1-2 2H4a2 2 0 0 1-2-2V7a2 2 0 0 1 2-2Zm0 2v10h16V7H4Zm1.5 1.5h2v2h-2v-2Zm3.7 0h2v2h-2v-2Zm3.6 0h2v2h-2v-2Zm3.7 0h2v2h-2v-2Zm-11 4h2v2h-2v-2Zm3.7 0h5.6v2H9.2v-2Zm7.3 0h2v2h-2v-2Z" />
        </svg>
      </ActionIcon>
      <Dialog opened={opened} onClose={close} title="Keyboard and name">
        <Stack gap="md">
          <dl className={classes.shortcuts}>
            <Shortcut keys={["Esc", "Esc"]}>
              Stop the robot: Escape twice within {TWICE_WITHIN_MS / 1000} s, anywhere but in a text field
            </Shortcut>
            <Shortcut keys={["Ctrl", "Shift", "X"]}>Stop the robot, also while you type</Shortcut>
            <Shortcut keys={["+", "−", "0"]}>In the picture: closer, farther, all of it</Shortcut>
            <Shortcut keys={["←", "↑", "→", "↓"]}>
              In the picture: move a simulated robot, with Shift turn it; Enter places it. Without a
              simulator, or with Ctrl: move the picture
            </Shortcut>
          </dl>
          <NameField />
        </Stack>
      </Dialog>
    </>
  );
}

function Shortcut({ keys, children }: { keys: string[]; children: ReactNode }) {
  return (
    <>
      <dt>
        {keys.map((key, index) => (
          // biome-ignore lint/suspicious/noArrayIndexKey: the same key can be there twice
          <Kbd key={index} mr={4}>
            {key}
          </Kbd>
        ))}
      </dt>
      <Text component="dd" size="sm">
        {children}
      </Text>
    </>
  );
}

function NameField() {
  const [name, setName] = useState(ownName);
  return (
    <TextInput
      label="Your name"
      description="Others read it where you stop the robot. It is kept in this browser."
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
