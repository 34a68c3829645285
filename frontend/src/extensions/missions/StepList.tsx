import { Group, Text, VisuallyHidden } from "@mantine/core";
import { type Ref, useEffect, useRef, useState } from "react";
import { useActions } from "../../actions/actions";
import { useFleet } from "../../fleet/context";
import { ReasonButton } from "../../ui/ReasonButton";
import { MAX_STEPS, newStep, type StepDraft, type StepKind, withMoved } from "./draft";
import classes from "./missions.module.css";
import { StepCard, TITLES } from "./StepCard";

interface StepListProps {
  steps: readonly StepDraft[];
  /** Whose docks and actions are offered. */
  robot: string;
  /** Whether somebody has tried to send the steps: then also what is missing is said. */
  tried: boolean;
  /** What is wrong with the list itself. */
  error: string | undefined;
  /** Whether steps can be written as JSON, where any value may be a parameter. */
  written?: boolean;
  onSteps: (edit: (steps: readonly StepDraft[]) => readonly StepDraft[]) => void;
}

/** Something in the list of steps that gets the focus when it is there. */
interface Sought {
  key: string;
  button: "up" | "down" | null;
}

/** Steps to fill in, to move and to remove, with buttons that add more. */
export function StepList({ steps, robot, tried, error, written = false, onSteps }: StepListProps) {
  const { store } = useFleet();
  const [said, say] = useState("");
  const sought = useRef<Sought | null>(null);
  const list = useRef<HTMLOListElement>(null);
  const adders = useRef<HTMLDivElement>(null);

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

  const add = (kind: StepKind) => {
    const step = newStep(kind, store.gatewayNow());
    sought.current = { key: step.key, button: null };
    onSteps((before) => [...before, step]);
    say(`Step ${steps.length + 1} added`);
  };
  const move = (index: number, by: -1 | 1) => {
    const step = steps[index];
    if (step === undefined) return;
    sought.current = { key: step.key, button: by === -1 ? "up" : "down" };
    onSteps((before) => withMoved(before, index, by));
    say(`Step ${index + 1} is now step ${index + by + 1}`);
  };
  const remove = (index: number) => {
    const near = steps[index + 1] ?? steps[index - 1];
    if (near === undefined) adders.current?.querySelector("button")?.focus();
    else sought.current = { key: near.key, button: null };
    onSteps((before) => before.filter((_, at) => at !== index));
    say(`Step ${index + 1} removed`);
  };

  return (
    <>
      {steps.length === 0 && (
        <Text size="sm" c="dimmed">
          Add the first step. The robot takes the steps one after the other.
        </Text>
      )}
      <ol className={classes.cards} ref={list} aria-label="Steps">
        {steps.map((step, index) => (
          <StepCard
            key={step.key}
            step={step}
            index={index}
            count={steps.length}
            robot={robot}
            later={namesOf(steps.slice(index + 1))}
            tried={tried}
            written={written}
            onChange={(edit) =>
              onSteps((before) => before.map((each) => (each.key === step.key ? edit(each) : each)))
            }
            onMove={(by) => move(index, by)}
            onRemove={() => remove(index)}
          />
        ))}
      </ol>
      <Adders robot={robot} full={steps.length >= MAX_STEPS} onAdd={add} ref={adders} />
      {error !== undefined && (
        <Text size="sm" c="var(--mantine-color-error)" role="alert">
          {error}
        </Text>
      )}
      <VisuallyHidden aria-live="polite">{said}</VisuallyHidden>
    </>
  );
}

function namesOf(steps: readonly StepDraft[]): string[] {
  return steps.map(({ name }) => name.trim()).filter((name) => name !== "");
}

/** The action by which nav2 drives a robot to a place. */
function navigatorOf(robot: string): string {
  return `${robot === "/" ? "" : robot}/navigate_to_pose`;
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
  ref: Ref<HTMLDivElement>;
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
