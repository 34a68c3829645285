import { Button, Group, Paper, SegmentedControl, Stack, Text } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { useId } from "react";
import type { Rule, RuleMode } from "../api/automation";
import { useFleetLive } from "../fleet/context";
import { robotsWords } from "../fleet/robotChoice";
import { useNaming } from "../fleet/useNaming";
import { ownName } from "../stop/who";
import { CommandErrorAlert } from "../ui/CommandErrorAlert";
import { Dialog } from "../ui/Dialog";
import { ReasonButton } from "../ui/ReasonButton";
import { Time } from "../ui/Time";
import classes from "./automation.module.css";
import { withMode } from "./draft";
import { RobotWaits } from "./RobotWaits";
import { SwitchOn } from "./SwitchOn";
import { useRuleCommands } from "./useAutomation";
import { conditionWords, MODES } from "./words";

const MODE_OPTIONS = Object.entries(MODES).map(([value, label]) => ({ value, label }));

/** A rule: when it docks which robots, and its mode to choose. */
export function RuleCard({ rule, onEdit }: { rule: Rule; onEdit: () => void }) {
  const naming = useNaming();
  const live = useFleetLive();
  const { save, remove } = useRuleCommands();
  const [asking, ask] = useDisclosure(false);
  const [removing, removal] = useDisclosure(false);
  const titleId = useId();
  const away = live ? null : "The gateway is not connected.";
  const setMode = (mode: RuleMode, by = ownName().trim() || null) =>
    save.mutate({ id: rule.id, body: withMode(rule, mode, by) });
  const choose = (value: string) => {
    const mode = value as RuleMode;
    if (mode === "on" && rule.mode !== "on") ask.open();
    else if (mode !== rule.mode) setMode(mode);
  };
  return (
    <Paper
      component="li"
      withBorder
      radius="md"
      p={{ base: "md", sm: "lg" }}
      className={classes.rule}
      aria-labelledby={titleId}
    >
      <div className={classes.head}>
        <Stack gap={2} className={classes.words}>
          <Text fw={600} id={titleId}>
            {rule.name}
          </Text>
          <Text size="sm">{conditionWords(rule)}</Text>
          <Text size="sm">{robotsWords(rule.robots, naming)}</Text>
          <Text size="sm" c="dimmed">
            Changed {rule.changed_by !== null && `by ${rule.changed_by}, `}
            <Time value={rule.changed_at} />
          </Text>
        </Stack>
        <Stack gap="xs" className={classes.commands}>
          <SegmentedControl
            aria-label={`Mode of ${rule.name}`}
            data={MODE_OPTIONS}
            value={rule.mode}
            onChange={choose}
            disabled={!live || save.isPending}
            {...(rule.mode === "on" ? { color: "green.9" } : {})}
          />
          <Group gap="xs" className={classes.buttons ?? ""}>
            <ReasonButton
              variant="default"
              size="compact-sm"
              reason={away}
              aria-label={`Edit ${rule.name}`}
              onClick={onEdit}
            >
              Edit
            </ReasonButton>
            <ReasonButton
              variant="default"
              size="compact-sm"
              reason={away}
              aria-label={`Remove ${rule.name}`}
              onClick={removal.open}
            >
              Remove
            </ReasonButton>
          </Group>
        </Stack>
      </div>
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
      <Dialog opened={removing} onClose={removal.close} title={`Remove ${rule.name}?`}>
        <Stack gap="md">
          <Text size="sm">Goals that it has sent go on. Its decisions stay in the list.</Text>
          <CommandErrorAlert command="Removing" error={remove.error} onClose={remove.reset} />
          <Group justify="flex-end" gap="sm">
            <Button variant="default" onClick={removal.close} data-autofocus>
              Keep it
            </Button>
            <Button
              color="red"
              loading={remove.isPending}
              onClick={() => remove.mutate(rule.id, { onSuccess: removal.close })}
            >
              Remove
            </Button>
          </Group>
        </Stack>
      </Dialog>
    </Paper>
  );
}
