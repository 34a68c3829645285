import { Alert, NumberInput, SegmentedControl, SimpleGrid, Text } from "@mantine/core";
import { EntryForm } from "../../entries/EntryForm";
import { useFleetTopic, useNaming } from "../../fleet/context";
import { RobotFields } from "../../fleet/RobotFields";
import { isCovered } from "../../fleet/robotChoice";
import { TimesOfDayFields } from "../../ui/TimesOfDayFields";
import {
  bodyOf,
  type Draft,
  type DraftErrors,
  draftOf,
  errorsOf,
  MAX_BELOW,
  MAX_IDLE_S,
  MAX_NAME,
  MAX_TIMES,
  MIN_BELOW,
  MIN_IDLE_S,
} from "./draft";
import type { Rule } from "./requests";
import { useRuleCommands } from "./rules";

interface RuleFormProps {
  /** Null for a new one. */
  rule: Rule | null;
  /** What a new one starts from. */
  example?: Partial<Draft> | undefined;
  /** All rules, as they are now. */
  rules: readonly Rule[];
  onDone: () => void;
}

/** Adds a rule, which is off, or changes one, which keeps its mode. */
export function RuleForm({ rule, example, rules, onDone }: RuleFormProps) {
  const { save } = useRuleCommands();
  return (
    <EntryForm
      noun="rule"
      entry={rule}
      draftOf={draftOf}
      example={example}
      entries={rules}
      placeholder="Low battery"
      maxName={MAX_NAME}
      errorsOf={errorsOf}
      bodyOf={(draft, by, replaced) => bodyOf(draft, replaced?.mode ?? "off", by)}
      save={save}
      onSaved={onDone}
      onCancel={onDone}
    >
      {(draft, errors, change) => (
        <>
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
            <BatteryFields draft={draft} errors={errors} onChange={change} />
          ) : (
            <TimesOfDayFields draft={draft} errors={errors} maxTimes={MAX_TIMES} onChange={change} />
          )}
          <RobotFields chosen={draft} error={errors.names} onChange={change} />
          <Covered draft={draft} />
          {rule?.mode === "on" && (
            <Alert color="orange" title="This rule is on">
              What you save applies at once.
            </Alert>
          )}
        </>
      )}
    </EntryForm>
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

interface FieldsProps {
  draft: Draft;
  errors: DraftErrors;
  onChange: (part: Partial<Draft>) => void;
}

/** How low the battery has to be, and for how long the robot idle. */
function BatteryFields({ draft, errors, onChange }: FieldsProps) {
  return (
    <SimpleGrid cols={{ base: 1, xs: 2 }} spacing="sm">
      <NumberInput
        label="Battery below"
        suffix=" %"
        min={MIN_BELOW}
        max={MAX_BELOW}
        step={5}
        decimalScale={1}
        value={draft.below}
        error={errors.below}
        onChange={(below) => onChange({ below })}
      />
      <NumberInput
        label="And idle for"
        suffix=" s"
        min={MIN_IDLE_S}
        max={MAX_IDLE_S}
        step={10}
        allowDecimal={false}
        value={draft.idleSeconds}
        error={errors.idleSeconds}
        onChange={(idleSeconds) => onChange({ idleSeconds })}
      />
    </SimpleGrid>
  );
}
