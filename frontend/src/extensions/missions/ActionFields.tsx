import { Code, Select, Skeleton, Text } from "@mantine/core";
import { useCallback, useMemo, useState } from "react";
import { useActions, useSchemas } from "../../actions/actions";
import { DraftFields, ModeSwitch } from "../../actions/DraftFields";
import { type Draft as GoalDraft, spaced } from "../../actions/form/draft";
import { type MessageShape, shapeOf } from "../../actions/form/shapes";
import { startingMessage, useDraftOf } from "../../actions/useDraft";
import { useNaming } from "../../fleet/context";
import { CommandErrorAlert } from "../../ui/errors";
import { useLatest } from "../../ui/useLatest";
import type { StepDraft } from "./draft";
import classes from "./missions.module.css";
import { type Edit, type FieldsProps, Refused } from "./StepFields";
import { errorAt, goalOf, withGoal } from "./wrong";

/** Which action, of those on the graph, and its goal. */
export function ActionFields({
  step,
  robot,
  errors,
  set,
  onChange,
}: FieldsProps & { robot: string; onChange: Edit }) {
  const naming = useNaming();
  const { data: actions, error, refetch } = useActions();
  const known = actions?.filter(({ installed }) => installed).map(({ action_name }) => action_name) ?? [];
  const names = step.action === "" || known.includes(step.action) ? known : [...known, step.action];
  const own = names.filter((name) => naming.ownerOf(name) === robot);
  const others = names.filter((name) => naming.ownerOf(name) !== robot);
  const groups = [
    { group: `Actions of ${naming.nameOf(robot)}`, items: own },
    { group: "Other actions", items: others },
  ].filter(({ items }) => items.length > 0);
  const choose = (name: string | null) => {
    const type = actions?.find(({ action_name }) => action_name === name)?.action_type ?? "";
    set({ action: name ?? "", goal: null, message: startingMessage(type) }, "action");
  };
  const action = actions?.find(({ action_name }) => action_name === step.action);
  return (
    <>
      <Select
        label="Action"
        placeholder={actions === undefined ? "Looking for actions" : "Choose an action"}
        description="Those that a server offers now."
        searchable
        nothingFoundMessage="No such action"
        data={groups}
        value={step.action === "" ? null : step.action}
        error={errorAt(errors, "action.name")}
        onChange={choose}
      />
      <CommandErrorAlert command="Looking for actions" error={error} onClose={() => void refetch()} />
      {action !== undefined ? (
        <ActionGoal key={step.action} step={step} type={action.action_type} onChange={onChange} />
      ) : (
        step.action !== "" &&
        actions !== undefined && (
          <div>
            <Text size="sm" mb={4}>
              No server offers this action now: the step waits for one. Its goal is sent as it was:
            </Text>
            <Code block>{spaced(step.message)}</Code>
            <Refused errors={errors} where="action.goal" />
          </div>
        )
      )}
    </>
  );
}

function ActionGoal({ step, type, onChange }: { step: StepDraft; type: string; onChange: Edit }) {
  const { data, error, refetch } = useSchemas(type);
  const shape = useMemo(() => (data === undefined ? null : shapeOf(data.goal)), [data]);
  return (
    <>
      <CommandErrorAlert command="Reading the interface" error={error} onClose={() => void refetch()} />
      {shape === null ? (
        error === null && <Skeleton height={60} />
      ) : (
        <GoalFields step={step} shape={step.goal?.shape ?? shape} onChange={onChange} />
      )}
    </>
  );
}

function GoalFields({ step, shape, onChange }: { step: StepDraft; shape: MessageShape; onChange: Edit }) {
  const edit = useLatest(onChange);
  const update = useCallback(
    (change: (before: GoalDraft) => GoalDraft) =>
      edit.current((before) => withGoal(before, shape, change(goalOf(before, shape)))),
    [shape],
  );
  const draft = useMemo(() => goalOf(step, shape), [step, shape]);
  const state = useDraftOf(draft, update, shape);
  const [sought, setSought] = useState<string | null>(null);
  const found = useCallback(() => setSought(null), []);
  return (
    <fieldset className={classes.goal}>
      <legend>Goal</legend>
      {shape.fields.length > 0 && (
        <div>
          <ModeSwitch state={state} label="Write the goal as" size="xs" />
        </div>
      )}
      <DraftFields state={state} shape={shape} sought={sought} onFound={found} />
    </fieldset>
  );
}
