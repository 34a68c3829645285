import { Button, Group, NumberInput, Stack, Text, TextInput, VisuallyHidden } from "@mantine/core";
import { type FormEvent, useEffect, useRef, useState } from "react";
import { useNavigate } from "react-router";
import { NameInput, ownName, setOwnName } from "../../access/who";
import { useActions } from "../../actions/actions";
import { refusedFields } from "../../actions/DraftFields";
import { useForbidden } from "../../api/session";
import { useGatewayNow } from "../../clock/clock";
import { useFleet, useFleetPart, useNaming, useWhyNot } from "../../fleet/context";
import { CommandErrorAlert } from "../../ui/errors";
import { ReasonButton } from "../../ui/ReasonButton";
import { useCommand } from "../../ui/requests";
import { Section } from "../../ui/Section";
import { BatteryFields } from "./BatteryFields";
import {
  bodyOf,
  type Draft,
  MAX_NAME,
  MAX_PRIORITY,
  MAX_STEPS,
  MIN_PRIORITY,
  newStep,
  type StepDraft,
  type StepKind,
  withMoved,
} from "./draft";
import classes from "./missions.module.css";
import { useOpenMissions } from "./openMissions";
import { queuesOf } from "./queue";
import { RobotField } from "./RobotField";
import { createMission } from "./requests";
import { StepCard, TITLES } from "./StepCard";
import { escaped, type TemplateDraft } from "./templates/templates";
import { errorAt, isReady, missionErrors, withRefused } from "./wrong";

interface MissionFormProps {
  draft: Draft;
  onChange: (change: (before: Draft) => Draft) => void;
}

/** Something in the list of steps that gets the focus when it is there. */
interface Sought {
  key: string;
  button: "up" | "down" | null;
}

/** The form of a mission, from its robot to its start. */
export function MissionForm({ draft, onChange }: MissionFormProps) {
  const { http, store } = useFleet();
  const navigate = useNavigate();
  const now = useGatewayNow();
  const reason = useWhyNot("POST /missions");
  const mayNotSave = useForbidden("PUT /mission-templates/{template_id}");
  const [tried, setTried] = useState(false);
  const [by, setBy] = useState(ownName);
  const [said, say] = useState("");
  const [more, setMore] = useState(false);
  const sought = useRef<Sought | null>(null);
  const list = useRef<HTMLOListElement>(null);
  const adders = useRef<HTMLDivElement>(null);

  const start = useCommand(async (body: string) => {
    try {
      return await createMission(http, draft.group === null ? draft.robot : null, body);
    } catch (error) {
      const refused = refusedFields(error);
      if (refused.length > 0) onChange((before) => withRefused(before, refused));
      throw error;
    }
  });

  // What was added or moved has the focus afterwards.
  useEffect(() => {
    if (sought.current === null) return;
    const { key, button } = sought.current;
    sought.current = null;
    const card = list.current?.querySelector<HTMLElement>(`[data-step="${key}"]`);
    const target =
      button === null ? card : card?.querySelector<HTMLElement>(`[data-move="${button}"]:enabled`);
    (target ?? card)?.focus();
  });

  const change = (part: Partial<Draft>) => onChange((before) => ({ ...before, ...part }));
  const setSteps = (edit: (steps: readonly StepDraft[]) => readonly StepDraft[]) =>
    onChange((before) => ({
      ...before,
      steps: edit(before.steps),
      refused: before.refused.filter(({ path }) => path !== "steps"),
    }));
  const add = (kind: StepKind) => {
    const step = newStep(kind, store.gatewayNow());
    sought.current = { key: step.key, button: null };
    setSteps((steps) => [...steps, step]);
    say(`Step ${draft.steps.length + 1} added`);
  };
  const move = (index: number, by: -1 | 1) => {
    const step = draft.steps[index];
    if (step === undefined) return;
    sought.current = { key: step.key, button: by === -1 ? "up" : "down" };
    setSteps((steps) => withMoved(steps, index, by));
    say(`Step ${index + 1} is now step ${index + by + 1}`);
  };
  const remove = (index: number) => {
    const near = draft.steps[index + 1] ?? draft.steps[index - 1];
    if (near === undefined) adders.current?.querySelector("button")?.focus();
    else sought.current = { key: near.key, button: null };
    setSteps((steps) => steps.filter((_, at) => at !== index));
    say(`Step ${index + 1} removed`);
  };

  const errors = [...missionErrors(draft).filter(({ missing }) => tried || !missing), ...draft.refused];
  const submit = (event: FormEvent) => {
    event.preventDefault();
    if (reason !== null || start.isPending) return;
    setTried(true);
    if (!isReady(draft, store.gatewayNow())) {
      const wrong = list.current?.parentElement?.querySelector<HTMLElement>("[aria-invalid=true]");
      wrong?.focus();
      return;
    }
    setOwnName(by.trim());
    start.mutate(bodyOf(draft, by.trim() || null), { onSuccess: () => navigate("/ui/missions") });
  };
  const others = draft.refused.filter(
    ({ path }) => !FIELDS.some((each) => path === each || path.startsWith(`${each}.`)),
  );
  const ready = isReady(draft, now);
  const wrongPriority = errorAt(errors, "priority") !== undefined;

  return (
    <form onSubmit={submit} noValidate>
      <Stack gap="md">
        <Section title="Mission">
          <div className={classes.fields}>
            <RobotField robot={draft.robot} onRobot={(robot) => change({ robot })} />
            <TextInput
              label="Name"
              description="Optional; without one its steps name it."
              placeholder="Night round"
              maxLength={MAX_NAME}
              value={draft.name}
              error={errorAt(errors, "name")}
              onChange={(event) => change({ name: event.currentTarget.value, refused: [] })}
            />
          </div>
          <BatteryFields
            battery={draft.battery}
            errors={errors}
            onChange={(battery) => change({ battery, refused: [] })}
          />
          <details
            className={classes.fold}
            open={more || wrongPriority}
            onToggle={(event) => setMore(event.currentTarget.open)}
          >
            <summary>More</summary>
            {(more || wrongPriority) && (
              <div className={classes.fields}>
                <NumberInput
                  label="Priority"
                  description="Of the missions that wait, the one with the highest number begins first."
                  min={MIN_PRIORITY}
                  max={MAX_PRIORITY}
                  clampBehavior="none"
                  allowDecimal={false}
                  value={draft.priority}
                  error={errorAt(errors, "priority")}
                  onChange={(priority) => change({ priority, refused: [] })}
                />
              </div>
            )}
          </details>
        </Section>
        <Section title="Steps">
          {draft.steps.length === 0 && (
            <Text size="sm" c="dimmed">
              Add the first step. The robot takes the steps one after the other.
            </Text>
          )}
          <ol className={classes.cards} ref={list} aria-label="Steps">
            {draft.steps.map((step, index) => (
              <StepCard
                key={step.key}
                step={step}
                index={index}
                count={draft.steps.length}
                robot={draft.robot}
                later={namesOf(draft.steps.slice(index + 1))}
                tried={tried}
                onChange={(edit) =>
                  setSteps((steps) => steps.map((each) => (each.key === step.key ? edit(each) : each)))
                }
                onMove={(by) => move(index, by)}
                onRemove={() => remove(index)}
              />
            ))}
          </ol>
          <Adders robot={draft.robot} full={draft.steps.length >= MAX_STEPS} onAdd={add} ref={adders} />
          {errorAt(errors, "steps") !== undefined && (
            <Text size="sm" c="var(--mantine-color-error)" role="alert">
              {errorAt(errors, "steps")}
            </Text>
          )}
          <VisuallyHidden aria-live="polite">{said}</VisuallyHidden>
        </Section>
        <Section title="Start">
          <Begins robot={draft.robot} />
          <div className={classes.fields}>
            <NameInput value={by} description="Shown with the mission." onChange={setBy} />
          </div>
          {others.map(({ path, detail }) => (
            <Text key={path} size="sm" c="var(--mantine-color-error)">
              {path}: {detail}
            </Text>
          ))}
          <CommandErrorAlert command="Starting the mission" error={start.error} onClose={start.reset} />
          <Group gap="sm">
            <ReasonButton type="submit" size="md" reason={reason} loading={start.isPending}>
              Start mission
            </ReasonButton>
            <Button variant="default" size="md" onClick={() => navigate("/ui/missions")}>
              Cancel
            </Button>
            {mayNotSave === null && (
              <ReasonButton
                variant="default"
                size="md"
                reason={ready ? null : "Fix what is marked first."}
                onClick={() => navigate("/ui/missions/templates", { state: templateOf(draft) })}
              >
                Save as template
              </ReasonButton>
            )}
            <Text size="sm" c="dimmed" role="status">
              {tried && !ready && "Fix what is marked above first."}
            </Text>
          </Group>
        </Section>
      </Stack>
    </form>
  );
}

/** Where the form shows what is wrong. */
const FIELDS = ["name", "priority", "battery", "steps"];

/** A template that makes this mission. */
function templateOf(draft: Draft): Partial<TemplateDraft> {
  const { steps } = JSON.parse(bodyOf(draft, null)) as { steps: unknown[] };
  return { name: draft.name, priority: draft.priority, steps: JSON.stringify(escaped(steps), null, 1) };
}

function namesOf(steps: readonly StepDraft[]): string[] {
  return steps.map(({ name }) => name.trim()).filter((name) => name !== "");
}

/** The action by which nav2 drives a robot to a place. */
function navigatorOf(robot: string): string {
  return `${robot === "/" ? "" : robot}/navigate_to_pose`;
}

/** When the mission begins. */
function Begins({ robot }: { robot: string }) {
  const name = useNaming().nameOf(robot);
  const { data: missions = [] } = useOpenMissions();
  const stopped = useFleetPart("robots", (robots) => robots.get(robot)?.stop.latched === true);
  const queue = queuesOf(missions).find((each) => each.robot === robot);
  const before = queue === undefined ? 0 : queue.next.length + (queue.active === null ? 0 : 1);
  const words =
    before === 0
      ? `${name} begins at once. Check that the area is clear.`
      : `${name} has ${before === 1 ? "another mission" : `${before} other missions`}: this one waits for its turn.`;
  return (
    <Text size="sm" role="status">
      {stopped
        ? `${name} is stopped: the mission is held until the stop is released and someone continues it.`
        : words}
    </Text>
  );
}

const KINDS: StepKind[] = [
  "dock",
  "undock",
  "action",
  "wait",
  "notify",
  "call",
  "publish",
  "repeat",
  "first_that_works",
];

interface AddersProps {
  robot: string;
  full: boolean;
  onAdd: (kind: StepKind) => void;
  ref: React.Ref<HTMLDivElement>;
}

function Adders({ robot, full, onAdd, ref }: AddersProps) {
  const { data: actions = [] } = useActions();
  const navigates = actions.some(({ action_name }) => action_name === navigatorOf(robot));
  const kinds: StepKind[] = navigates ? ["navigate", ...KINDS] : KINDS;
  return (
    <Group gap="xs" ref={ref} role="group" aria-label="Add a step">
      <Text size="sm" aria-hidden="true">
        Add a step:
      </Text>
      {kinds.map((kind) => (
        <ReasonButton
          key={kind}
          variant="default"
          reason={full ? `A mission has at most ${MAX_STEPS} steps.` : null}
          aria-label={`Add step: ${TITLES[kind]}`}
          onClick={() => onAdd(kind)}
        >
          {TITLES[kind]}
        </ReasonButton>
      ))}
    </Group>
  );
}
