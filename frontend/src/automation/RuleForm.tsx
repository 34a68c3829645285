import { Alert, SegmentedControl, Stack, Text, TextInput } from "@mantine/core";
import { type FormEvent, useState } from "react";
import { NameInput } from "../access/NameInput";
import { ownName, setOwnName } from "../access/who";
import type { Rule } from "../api/automation";
import { useFleetTopic, useNaming } from "../fleet/context";
import { RobotFields } from "../fleet/RobotFields";
import { isCovered } from "../fleet/robotChoice";
import { SaveBar } from "../ui/Dialog";
import { newId } from "../ui/text";
import { BatteryFields } from "./BatteryFields";
import { bodyOf, type Draft, draftOf, errorsOf, MAX_NAME } from "./draft";
import { ScheduleFields } from "./ScheduleFields";
import { useRuleCommands } from "./useAutomation";

interface RuleFormProps {
  /** Null for a new one. */
  rule: Rule | null;
  /** All of them. */
  rules: readonly Rule[];
  onDone: () => void;
}

/** Adds a rule, which is off, or changes one, which keeps its mode. */
export function RuleForm({ rule, rules, onDone }: RuleFormProps) {
  const [draft, setDraft] = useState(() => draftOf(rule));
  const [by, setBy] = useState(ownName);
  const [tried, setTried] = useState(false);
  const { save } = useRuleCommands();
  // The current mode: the rule may have been switched since the form was opened. A removed rule is saved as off.
  const mode = rules.find(({ id }) => id === rule?.id)?.mode ?? "off";
  const errors = errorsOf(draft);
  const shown = tried ? errors : {};
  const change = (part: Partial<Draft>) => setDraft((before) => ({ ...before, ...part }));
  const submit = (event: FormEvent) => {
    event.preventDefault();
    setTried(true);
    if (Object.keys(errors).length > 0) return;
    setOwnName(by.trim());
    const id =
      rule?.id ??
      newId(
        draft.name,
        rules.map((each) => each.id),
        "rule",
      );
    const body = bodyOf(draft, mode, by.trim() || null);
    save.mutate({ id, body }, { onSuccess: onDone });
  };
  return (
    <form onSubmit={submit} noValidate>
      <Stack gap="md">
        <TextInput
          label="Name"
          placeholder="Low battery"
          maxLength={MAX_NAME}
          value={draft.name}
          error={shown.name}
          onChange={(event) => change({ name: event.currentTarget.value })}
          data-autofocus
        />
        <SegmentedControl
          aria-label="Condition"
          data={[
            { value: "battery", label: "Low battery" },
            { value: "schedule", label: "Times of day" },
          ]}
          value={draft.condition}
          onChange={(value) => change({ condition: value as Draft["condition"] })}
        />
        {draft.condition === "battery" ? (
          <BatteryFields draft={draft} errors={shown} onChange={change} />
        ) : (
          <ScheduleFields draft={draft} errors={shown} onChange={change} />
        )}
        <RobotFields chosen={draft} error={shown.names} onChange={change} />
        <Covered draft={draft} />
        {mode === "on" && (
          <Alert color="orange" title="This rule is on">
            What you save applies at once.
          </Alert>
        )}
        <NameInput value={by} description="Shown with the rule." onChange={setBy} />
        <SaveBar save={save} onCancel={onDone} />
      </Stack>
    </form>
  );
}

/** The robots that the rule would apply to now. */
function Covered({ draft }: { draft: Draft }) {
  const naming = useNaming();
  const robots = [...useFleetTopic("robots").values()].filter(({ name, groups }) =>
    isCovered(draft, name, groups),
  );
  const names = robots.map(({ name }) => naming.nameOf(name)).join(", ");
  return (
    <Text size="sm" c="dimmed" aria-live="polite">
      {robots.length === 0 ? "Applies to no robot now" : `Applies now to ${names}`}
    </Text>
  );
}
