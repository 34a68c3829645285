import { Button, Chip, Group, NativeSelect, TextInput } from "@mantine/core";
import { useEffect, useState } from "react";
import { useActions } from "../actions/actions";
import { useFleet, useFleetTopic } from "../fleet/context";
import { GroupSelect, RobotSelect } from "../fleet/RobotFields";
import { codeWords } from "../goal/words";
import { TimeRangeField } from "../ui/TimeRangeField";
import { sentence } from "../ui/text";
import { type GoalFilter, type GoalState, goalFilter, ID_BEGINNING, type Origin, STATES } from "./filter";
import classes from "./goals.module.css";
import { TagSelect } from "./TagSelect";

interface GoalFiltersProps {
  filter: GoalFilter;
  change: (part: Partial<GoalFilter>) => void;
}

/** What to narrow the list by. */
export function GoalFilters({ filter, change }: GoalFiltersProps) {
  const { store } = useFleet();
  const actions = useActionNames(filter.actions);
  return (
    <section aria-label="Filter the goals">
      <TimeRangeField
        value={filter.time}
        onChange={(time) => change({ time })}
        now={() => store.gatewayNow()}
        any
      />
      <div className={classes.filters}>
        <RobotSelect label="Robot" robot={filter.robot} onRobot={(robot) => change({ robot })} />
        <GroupSelect label="Group" group={filter.group} onGroup={(group) => change({ group })} />
        <NativeSelect
          label="Action"
          value={filter.actions.join(" ")}
          onChange={(event) => change({ actions: event.currentTarget.value.split(" ").filter(Boolean) })}
          data={[{ value: "", label: "All actions" }, ...actions]}
        />
        <NativeSelect
          label="Origin"
          value={filter.origin ?? ""}
          onChange={(event) => change({ origin: (event.currentTarget.value || null) as Origin | null })}
          data={[
            { value: "", label: "Anyone" },
            { value: "gateway", label: "This gateway" },
            { value: "automation", label: "A rule (automatic)" },
            { value: "external", label: "Someone else (external)" },
          ]}
        />
        {filter.errors.length > 0 && (
          <NativeSelect
            label="Error"
            value="chosen"
            onChange={() => change({ errors: [] })}
            data={[
              { value: "", label: "With and without" },
              { value: "chosen", label: filter.errors.map(codeWords).join(" or ") },
            ]}
          />
        )}
        <TagSelect
          label="Tag"
          any="With and without"
          chosen={filter.tags}
          onTags={(tags) => change({ tags })}
        />
        <IdFilter id={filter.id} onId={(id) => change({ id })} />
      </div>
      <Group gap="xs" mt="sm">
        <Chip.Group
          multiple
          value={[...filter.states]}
          onChange={(states) => change({ states: STATES.filter((state) => states.includes(state)) })}
        >
          <Group gap={6} role="group" aria-label="Status">
            {STATES.map((state: GoalState) => (
              <Chip key={state} value={state} size="sm" variant="outline">
                {sentence(state)}
              </Chip>
            ))}
          </Group>
        </Chip.Group>
        <Button
          variant="subtle"
          size="compact-sm"
          disabled={goalFilter.isInitial(filter)}
          title={goalFilter.isInitial(filter) ? "Nothing is filtered" : undefined}
          onClick={() => change(goalFilter.initial)}
        >
          Clear filters
        </Button>
      </Group>
    </section>
  );
}

/** Keeps what is typed to itself until it is the beginning of an id. */
function IdFilter({ id, onId }: { id: string; onId: (id: string) => void }) {
  const [text, setText] = useState(id);
  useEffect(() => setText(id), [id]);
  const invalid = /[^0-9a-f-]/i.test(text) || (text.length >= 4 && !ID_BEGINNING.test(text));
  return (
    <TextInput
      type="search"
      label="Goal id"
      placeholder="First 4 digits or more"
      spellCheck={false}
      value={text}
      error={invalid && "Hexadecimal digits and dashes"}
      onChange={(event) => {
        const typed = event.currentTarget.value.trim();
        setText(typed);
        if (typed === "" || ID_BEGINNING.test(typed)) onId(typed);
      }}
      onBlur={() => !invalid && setText(id)}
    />
  );
}

/** The actions on the graph, and those of the goals that are known. */
function useActionNames(chosen: readonly string[]): { value: string; label: string }[] {
  const goals = useFleetTopic("goals");
  const { data: actions = [] } = useActions();
  const names = new Set([
    ...actions.map((action) => action.action_name),
    ...[...goals.values()].map((goal) => goal.action_name),
    ...chosen,
  ]);
  const options = [...names].sort().map((name) => ({ value: name, label: name }));
  const several = { value: chosen.join(" "), label: chosen.join(" and ") };
  return chosen.length > 1 ? [several, ...options] : options;
}
