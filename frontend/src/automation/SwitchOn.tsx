import { Button, Group, List, Stack, Text } from "@mantine/core";
import { useState } from "react";
import { NameInput, useOwnName } from "../access/NameInput";
import { setOwnName } from "../access/who";
import type { Rule } from "../api/automation";
import { useNaming } from "../fleet/context";
import { Dialog } from "../ui/Dialog";
import classes from "./automation.module.css";
import { conditionWords } from "./words";

interface SwitchOnProps {
  rule: Rule;
  opened: boolean;
  onClose: () => void;
  onSwitch: (by: string | null) => void;
}

/** Asks before robots move by themselves, with the names of those that this is about. */
export function SwitchOn({ rule, opened, onClose, onSwitch }: SwitchOnProps) {
  return (
    <Dialog opened={opened} onClose={onClose} title={`Switch on ${rule.name}?`}>
      {opened && <Question rule={rule} onClose={onClose} onSwitch={onSwitch} />}
    </Dialog>
  );
}

function Question({ rule, onClose, onSwitch }: Omit<SwitchOnProps, "opened">) {
  const naming = useNaming();
  const [name, setName] = useState(useOwnName());
  const robots = rule.applies_to.map(({ robot }) => naming.fullNameOf(robot));
  return (
    <Stack gap="md">
      <Text size="sm">{willDrive(robots.length)}</Text>
      {robots.length > 0 && (
        <List size="sm" className={classes.names ?? ""}>
          {robots.map((robot) => (
            <List.Item key={robot}>{robot}</List.Item>
          ))}
        </List>
      )}
      <Text size="sm" fw={600}>
        {conditionWords(rule)}
      </Text>
      <Text size="sm">Check that the ways to the docks are clear.</Text>
      <NameInput value={name} description="Shown with the rule." onChange={setName} />
      <Group justify="flex-end" gap="sm">
        <Button variant="default" onClick={onClose} data-autofocus>
          Cancel
        </Button>
        <Button
          onClick={() => {
            setOwnName(name.trim());
            onSwitch(name.trim() || null);
          }}
        >
          Switch on
        </Button>
      </Group>
    </Stack>
  );
}

function willDrive(robots: number): string {
  if (robots === 0)
    return "It applies to no robot now. Robots that it applies to later dock without being asked.";
  return robots === 1
    ? "This robot will drive to its dock without being asked:"
    : `These ${robots} robots will drive to their docks without being asked:`;
}
