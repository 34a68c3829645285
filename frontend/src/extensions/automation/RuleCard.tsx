import { Anchor, Button, List, SegmentedControl, Stack, Text } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { useState } from "react";
import { Link } from "react-router";
import { NameInput, ownName, setOwnName, useOwnName } from "../../access/who";
import { EntryCard } from "../../entries/EntryCard";
import { useNaming, useWhyNot } from "../../fleet/context";
import { robotPath } from "../../fleet/names";
import { robotsWords } from "../../fleet/robotChoice";
import { Dialog, QuestionBar } from "../../ui/Dialog";
import { CommandErrorAlert } from "../../ui/errors";
import classes from "./automation.module.css";
import { withMode } from "./draft";
import type { Rule, RuleMode } from "./requests";
import { isStopped, useRuleCommands } from "./rules";
import { conditionWords, MODES, WAITS } from "./words";

const MODE_OPTIONS = Object.entries(MODES).map(([value, label]) => ({ value, label }));

/** A rule: when it docks which robots, and its mode to choose. */
export function RuleCard({ rule, onEdit }: { rule: Rule; onEdit: () => void }) {
  const naming = useNaming();
  const reason = useWhyNot("PUT /automation/rules/{rule_id}");
  const { save, remove } = useRuleCommands();
  const [asking, ask] = useDisclosure(false);
  const setMode = (mode: RuleMode, by = ownName().trim() || null) =>
    save.mutate({ id: rule.id, body: withMode(rule, mode, by), base: rule });
  const choose = (value: string) => {
    const mode = value as RuleMode;
    if (mode === "on" && rule.mode !== "on") ask.open();
    else if (mode !== rule.mode) setMode(mode);
  };
  return (
    <EntryCard
      entry={rule}
      words={[conditionWords(rule), robotsWords(rule.robots, naming)]}
      control={
        <SegmentedControl
          aria-label={`Mode of ${rule.name}`}
          data={MODE_OPTIONS}
          value={rule.mode}
          onChange={choose}
          disabled={reason !== null || save.isPending}
          title={reason ?? undefined}
          {...(rule.mode === "on" ? { color: "green.9" } : {})}
        />
      }
      reason={reason}
      onEdit={onEdit}
      remove={remove}
      removal="Goals that it has sent go on. Its decisions stay in the list."
    >
      <RobotWaits rule={rule} />
      <CommandErrorAlert command="Saving" error={save.error} onClose={save.reset} />
      <SwitchOn
        rule={rule}
        opened={asking}
        onClose={ask.close}
        onSwitch={(by) => {
          ask.close();
          setMode("on", by);
        }}
      />
    </EntryCard>
  );
}

/** The robots that a rule applies to now, and what it waits for. */
function RobotWaits({ rule }: { rule: Rule }) {
  const naming = useNaming();
  const reason = useWhyNot("DELETE /automation/holds");
  const { goOn } = useRuleCommands();
  const count = rule.applies_to.length;
  if (count === 0) {
    return (
      <Text size="sm" c="dimmed">
        Applies to no robot now
      </Text>
    );
  }
  return (
    <details className={classes.waits} open={rule.mode !== "off" && rule.applies_to.some(isStopped)}>
      <summary>Applies to {count === 1 ? "one robot" : `${count} robots`} now</summary>
      <ul>
        {rule.applies_to.map(({ robot, waits_for }) => (
          <li key={robot}>
            <Anchor component={Link} to={robotPath(robot)} size="sm" underline="always">
              {naming.fullNameOf(robot)}
            </Anchor>
            {rule.mode !== "off" && (
              <Text span size="sm" c="dimmed">
                {WAITS[waits_for]}
              </Text>
            )}
            {rule.mode !== "off" && isStopped({ robot, waits_for }) && (
              <Button
                size="compact-sm"
                variant="default"
                aria-label={`Continue automatic docking of ${naming.fullNameOf(robot)}`}
                disabled={reason !== null || goOn.isPending}
                title={reason ?? undefined}
                onClick={() => goOn.mutate(robot)}
              >
                Continue
              </Button>
            )}
          </li>
        ))}
      </ul>
      <CommandErrorAlert command="Continuing" error={goOn.error} onClose={goOn.reset} />
    </details>
  );
}

interface SwitchOnProps {
  rule: Rule;
  opened: boolean;
  onClose: () => void;
  onSwitch: (by: string | null) => void;
}

/** Asks before robots move by themselves, with the names of those that this is about. */
function SwitchOn({ rule, opened, onClose, onSwitch }: SwitchOnProps) {
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
      <QuestionBar
        keep="Cancel"
        onKeep={onClose}
        go="Switch on"
        onGo={() => {
          setOwnName(name.trim());
          onSwitch(name.trim() || null);
        }}
      />
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
