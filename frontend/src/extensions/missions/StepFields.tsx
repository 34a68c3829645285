import {
  Checkbox,
  Code,
  NativeSelect,
  NumberInput,
  SegmentedControl,
  Select,
  Skeleton,
  Text,
  TextInput,
} from "@mantine/core";
import { useCallback, useMemo, useState } from "react";
import { useActions, useSchemas } from "../../actions/actions";
import { DraftFields, ModeSwitch } from "../../actions/DraftFields";
import { type Draft as GoalDraft, spaced } from "../../actions/form/draft";
import { type MessageShape, shapeOf } from "../../actions/form/shapes";
import { startingMessage, useDraftOf } from "../../actions/useDraft";
import { useFleet, useFleetPart, useNaming } from "../../fleet/context";
import { CommandErrorAlert } from "../../ui/errors";
import { useAnswer } from "../../ui/requests";
import { useLatest } from "../../ui/useLatest";
import {
  isBlock,
  isInterruptible,
  MAX_STEP_NAME,
  MAX_TIMEOUT_S,
  MAX_TRIES,
  MAX_WAIT_S,
  MIN_TIMEOUT_S,
  MIN_TRIES,
  type StepDraft,
  type WaitKind,
} from "./draft";
import classes from "./missions.module.css";
import { optionWords, secondsWords } from "./words";
import { errorAt, goalOf, type Wrong, withGoal } from "./wrong";

/** Changes a step. */
export type Edit = (edit: (before: StepDraft) => StepDraft) => void;

export interface FieldsProps {
  step: StepDraft;
  errors: readonly Wrong[];
  set: (part: Partial<StepDraft>, ...paths: string[]) => void;
}

/** What the gateway has refused of something that has no field here. */
export function Refused({ errors, where }: { errors: readonly Wrong[]; where: string }) {
  const error = errorAt(errors, where);
  if (error === undefined) return null;
  return (
    <Text size="sm" c="var(--mantine-color-error)">
      {error}
    </Text>
  );
}

/** Which dock: the default one, or one that the robot's docking server knows by name. */
export function DockFields({ step, robot, errors, set }: FieldsProps & { robot: string }) {
  const { gatewayOf } = useFleet();
  const available = useFleetPart("robots", (robots) => robots.get(robot)?.dock?.available === true);
  const { data } = useAnswer({
    queryKey: ["docks of", robot],
    queryFn: () => gatewayOf(robot).docks(),
    enabled: available,
  });
  const names = data?.docks.map(({ dock_id }) => dock_id) ?? [];
  const all = step.dock === "" || names.includes(step.dock) ? names : [...names, step.dock];
  const standard = data?.default ?? null;
  if (all.length === 0)
    return (
      <>
        <Text size="sm" c="dimmed">
          At the robot's dock.
        </Text>
        <Refused errors={errors} where="dock" />
      </>
    );
  return (
    <div className={classes.fields}>
      <NativeSelect
        label="Dock at"
        value={step.dock}
        error={errorAt(errors, "dock")}
        onChange={(event) => set({ dock: event.currentTarget.value }, "dock")}
        data={[
          { value: "", label: standard === null ? "The default dock" : `The default dock (${standard})` },
          ...all.map((name) => ({ value: name, label: name })),
        ]}
      />
    </div>
  );
}

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

const WAITS: { value: WaitKind; label: string }[] = [
  { value: "seconds", label: "Seconds" },
  { value: "until", label: "Time" },
  { value: "battery", label: "Battery" },
  { value: "person", label: "Person" },
];

/** What to wait for. */
export function WaitFields({ step, errors, set }: FieldsProps) {
  const until = errorAt(errors, "wait.until");
  return (
    <>
      <SegmentedControl
        aria-label="Wait for"
        data={WAITS}
        value={step.wait}
        onChange={(wait) => set({ wait: wait as WaitKind }, "wait")}
        className={classes.kinds ?? ""}
      />
      {step.wait === "seconds" && (
        <div className={classes.fields}>
          <NumberInput
            label="Wait for"
            suffix=" s"
            min={0}
            max={MAX_WAIT_S}
            clampBehavior="none"
            value={step.seconds}
            error={errorAt(errors, "wait.seconds")}
            description={
              typeof step.seconds === "number" && step.seconds >= 60 ? secondsWords(step.seconds) : undefined
            }
            onChange={(seconds) => set({ seconds }, "wait")}
          />
        </div>
      )}
      {step.wait === "until" && (
        <div className={classes.fields}>
          <TextInput
            label="Day"
            type="date"
            value={step.day}
            error={until}
            onChange={(event) => set({ day: event.currentTarget.value }, "wait")}
          />
          <TextInput
            label="Time"
            placeholder="06:00"
            maxLength={5}
            value={step.clock}
            error={until !== undefined}
            onChange={(event) => set({ clock: event.currentTarget.value }, "wait")}
          />
        </div>
      )}
      {step.wait === "battery" && (
        <div className={classes.fields}>
          <NumberInput
            label="Until the battery has"
            suffix=" %"
            min={0.1}
            max={100}
            step={5}
            decimalScale={1}
            clampBehavior="none"
            value={step.charge}
            error={errorAt(errors, "wait.battery")}
            onChange={(charge) => set({ charge }, "wait")}
          />
        </div>
      )}
      {step.wait === "person" && (
        <Text size="sm" c="dimmed">
          The mission is held until someone presses Continue.
        </Text>
      )}
      {errorAt(errors, "wait") !== undefined && errors.some(({ path }) => path === "wait") && (
        <Refused errors={errors.filter(({ path }) => path === "wait")} where="wait" />
      )}
    </>
  );
}

const GO_TO = "go to ";

function policyOf(value: string): StepDraft["onFailure"] {
  if (value.startsWith(GO_TO)) return { go_to: value.slice(GO_TO.length) };
  return value === "next" ? "next" : "end";
}

/** A time limit, tries, what a failure means, and a name. */
export function Options({ step, later, errors, set }: FieldsProps & { later: readonly string[] }) {
  const { onFailure } = step;
  const target = typeof onFailure === "object" ? onFailure.go_to : null;
  const targets = target === null || later.includes(target) ? later : [...later, target];
  const wrong = ["name", "timeout_s", "tries", "on_failure", "interruptible"].some(
    (path) => errorAt(errors, path) !== undefined,
  );
  const [opened, setOpened] = useState(false);
  const words = optionWords({
    tries: Number(step.tries),
    timeout_s: step.timeout === "" ? null : Number(step.timeout),
    on_failure: step.onFailure,
    interruptible: isInterruptible(step.kind) && step.interruptible,
  });
  return (
    <details
      className={classes.fold}
      open={opened || wrong}
      onToggle={(event) => setOpened(event.currentTarget.open)}
    >
      <summary>
        Options
        {words !== "" && (
          <Text span size="sm" c="dimmed">
            : {words}
          </Text>
        )}
      </summary>
      {(opened || wrong) && (
        <div className={classes.fields}>
          {!isBlock(step.kind) && (
            <>
              <NumberInput
                label="Time limit"
                description="A goal that runs is canceled then. Empty: no limit."
                suffix=" s"
                min={MIN_TIMEOUT_S}
                max={MAX_TIMEOUT_S}
                clampBehavior="none"
                value={step.timeout}
                error={errorAt(errors, "timeout_s")}
                onChange={(timeout) => set({ timeout }, "timeout_s")}
              />
              <NumberInput
                label="Tries"
                description="Five seconds apart."
                min={MIN_TRIES}
                max={MAX_TRIES}
                clampBehavior="none"
                allowDecimal={false}
                value={step.tries}
                error={errorAt(errors, "tries")}
                onChange={(tries) => set({ tries }, "tries")}
              />
            </>
          )}
          <NativeSelect
            label="If it fails"
            description="After the last try."
            value={target === null ? String(onFailure) : GO_TO + target}
            error={errorAt(errors, "on_failure")}
            onChange={(event) => set({ onFailure: policyOf(event.currentTarget.value) }, "on_failure")}
            data={[
              { value: "end", label: "End the mission" },
              { value: "next", label: "Go on with the next step" },
              ...targets.map((name) => ({ value: GO_TO + name, label: `Go to ${name}` })),
            ]}
          />
          <TextInput
            label="Step name"
            description="Steps before it can go to it."
            maxLength={MAX_STEP_NAME}
            value={step.name}
            error={errorAt(errors, "name")}
            onChange={(event) => set({ name: event.currentTarget.value }, "name")}
          />
          {isInterruptible(step.kind) && (
            <Checkbox
              label="Leave it when the robot has to charge"
              description="Its goal is canceled, and the step begins again afterwards. Otherwise it is finished first."
              checked={step.interruptible}
              error={errorAt(errors, "interruptible")}
              onChange={(event) => set({ interruptible: event.currentTarget.checked }, "interruptible")}
            />
          )}
        </div>
      )}
    </details>
  );
}
