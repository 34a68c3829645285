import { Button, NativeSelect, TextInput } from "@mantine/core";
import { type KeyboardEvent, useEffect, useState } from "react";
import { useFleet } from "../../fleet/context";
import { RobotSelect } from "../../fleet/RobotFields";
import { TimeRangeField } from "../../ui/TimeRangeField";
import classes from "./audit.module.css";
import {
  type AuditFilter,
  auditFilter,
  GOAL_ID,
  OUTCOME_WORDS,
  OUTCOMES,
  type Outcome,
  WHAT_WORDS,
  whatWords,
} from "./filter";

interface AuditFiltersProps {
  filter: AuditFilter;
  change: (part: Partial<AuditFilter>) => void;
}

/** What to narrow the list by. */
export function AuditFilters({ filter, change }: AuditFiltersProps) {
  const { store } = useFleet();
  const filtered = !auditFilter.isInitial(filter);
  return (
    <section aria-label="Filter the records">
      <TimeRangeField
        value={filter.time}
        onChange={(time) => change({ time })}
        now={() => store.gatewayNow()}
        any
      />
      <div className={classes.filters}>
        <LateField label="Who" value={filter.principal} onValue={(principal) => change({ principal })} />
        <NativeSelect
          label="What"
          value={filter.what}
          onChange={(event) => change({ what: event.currentTarget.value })}
          data={[{ value: "", label: "Everything" }, ...whatOptions(filter.what)]}
        />
        <RobotSelect
          label="Robot"
          robot={filter.robot || null}
          onRobot={(robot) => change({ robot: robot ?? "" })}
        />
        <NativeSelect
          label="Outcome"
          value={filter.outcome ?? ""}
          onChange={(event) => change({ outcome: (event.currentTarget.value || null) as Outcome | null })}
          data={[
            { value: "", label: "Any" },
            ...OUTCOMES.map((value) => ({ value, label: OUTCOME_WORDS[value] })),
          ]}
        />
        <LateField
          label="Goal id"
          value={filter.goalId}
          onValue={(goalId) => change({ goalId })}
          isValid={(text) => GOAL_ID.test(text)}
          invalid="The whole id of a goal"
        />
        <Button
          variant="subtle"
          disabled={!filtered}
          title={filtered ? undefined : "Nothing is filtered"}
          onClick={() => change(auditFilter.initial)}
        >
          Clear filters
        </Button>
      </div>
    </section>
  );
}

interface LateFieldProps {
  label: string;
  value: string;
  onValue: (value: string) => void;
  isValid?: (text: string) => boolean;
  invalid?: string;
}

/** Keeps what is typed to itself until Enter is pressed or the field is left. */
function LateField({ label, value, onValue, isValid = () => true, invalid }: LateFieldProps) {
  const [text, setText] = useState(value);
  useEffect(() => setText(value), [value]);
  const typed = text.trim();
  const wrong = typed !== "" && !isValid(typed);
  const apply = () => {
    if (!wrong && typed !== value) onValue(typed);
  };
  return (
    <TextInput
      type="search"
      label={label}
      placeholder="Any"
      spellCheck={false}
      maxLength={100}
      value={text}
      error={wrong && invalid}
      onChange={(event) => setText(event.currentTarget.value)}
      onKeyDown={(event: KeyboardEvent) => event.key === "Enter" && apply()}
      onBlur={apply}
    />
  );
}

/** Sorted by their words; operations with the same words are distinguished by their names. */
function whatOptions(chosen: string): { value: string; label: string }[] {
  const names = [...new Set([...Object.keys(WHAT_WORDS), ...(chosen === "" ? [] : [chosen])])];
  const words = names.map(whatWords);
  return names
    .map((value, index) => {
      const label = words[index] ?? value;
      return {
        value,
        label: words.filter((each) => each === label).length > 1 ? `${label} (${value})` : label,
      };
    })
    .sort((a, b) => a.label.localeCompare(b.label));
}
