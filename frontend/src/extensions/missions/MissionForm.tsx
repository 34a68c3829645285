import { Button, Group, NumberInput, Stack, Text, TextInput } from "@mantine/core";
import { type FormEvent, useRef, useState } from "react";
import { useNavigate } from "react-router";
import { NameInput, ownName, setOwnName } from "../../access/who";
import { useForbidden } from "../../api/session";
import { useGatewayNow } from "../../clock/clock";
import { useFleet, useWhyNot } from "../../fleet/context";
import { Conflict, isConflict } from "../../ui/Conflict";
import { CommandErrorAlert } from "../../ui/errors";
import { ReasonButton } from "../../ui/ReasonButton";
import { Section } from "../../ui/Section";
import { BatteryFields } from "./BatteryFields";
import { Begins } from "./Begins";
import { type Draft, MAX_NAME, MAX_PRIORITY, MIN_PRIORITY, type StepDraft } from "./draft";
import { missionPath } from "./MissionCard";
import { useSaveMission } from "./missions";
import classes from "./missions.module.css";
import { hasBegun } from "./queue";
import type { Mission } from "./requests";
import { StepList } from "./StepList";
import { TakerField, useExampleRobot } from "./TakerField";
import { type Example, escaped } from "./templates/templates";
import { bodyOf } from "./toRequest";
import { errorAt, isReady, missionErrors } from "./wrong";

/** A mission that is edited. */
interface Edited {
  /** As it was when the form was filled. */
  base: Mission;
  /** As it is now. */
  newest: Mission;
  /** Fills the form with it as it is now. */
  onShow: (newest: Mission) => void;
}

interface MissionFormProps {
  draft: Draft;
  onChange: (change: (before: Draft) => Draft) => void;
  /** Null for a new one. */
  edited?: Edited | null;
}

/** The form of a mission, from its robot to its start. */
export function MissionForm({ draft, onChange, edited = null }: MissionFormProps) {
  const { store } = useFleet();
  const navigate = useNavigate();
  const now = useGatewayNow();
  const whyNot = useWhyNot(edited === null ? "POST /missions" : "PUT /missions/{mission_id}");
  const mayNotSave = useForbidden("PUT /mission-templates/{template_id}");
  const [tried, setTried] = useState(false);
  const [by, setBy] = useState(ownName);
  const form = useRef<HTMLFormElement>(null);
  const save = useSaveMission(draft, onChange);
  const robot = useExampleRobot(draft);
  const begun = edited !== null && hasBegun(edited.newest);
  const reason = begun ? "It has begun." : whyNot;

  const change = (part: Partial<Draft>) => onChange((before) => ({ ...before, ...part }));
  const setSteps = (edit: (steps: readonly StepDraft[]) => readonly StepDraft[]) =>
    onChange((before) => ({
      ...before,
      steps: edit(before.steps),
      refused: before.refused.filter(({ path }) => path !== "steps"),
    }));

  const errors = [...missionErrors(draft).filter(({ missing }) => tried || !missing), ...draft.refused];
  const send = (base: Mission | null) => {
    if (reason !== null || save.isPending) return;
    setTried(true);
    if (!isReady(draft, store.gatewayNow())) {
      form.current?.querySelector<HTMLElement>("[aria-invalid=true]")?.focus();
      return;
    }
    if (base === null) setOwnName(by.trim());
    const body = bodyOf(draft, base === null ? by.trim() || null : null);
    save.mutate({ body, base }, { onSuccess: () => navigate("/ui/missions") });
  };
  const submit = (event: FormEvent) => {
    event.preventDefault();
    send(edited?.base ?? null);
  };
  const ready = isReady(draft, now);
  return (
    <form onSubmit={submit} noValidate ref={form}>
      <Stack gap="md">
        <Section title="Mission">
          <div className={classes.fields}>
            {edited === null && (
              <TakerField robot={draft.robot} group={draft.group} onTaker={(taker) => change(taker)} />
            )}
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
          <More draft={draft} error={errorAt(errors, "priority")} onChange={change} />
        </Section>
        <Section title="Steps" help="extensions/missions#steps">
          <StepList
            steps={draft.steps}
            robot={robot}
            tried={tried}
            error={errorAt(errors, "steps")}
            onSteps={setSteps}
          />
        </Section>
        <Section title={edited === null ? "Start" : "Save"}>
          {edited === null && (
            <>
              <Begins robot={draft.robot} group={draft.group} />
              <div className={classes.fields}>
                <NameInput value={by} description="Shown with the mission." onChange={setBy} />
              </div>
            </>
          )}
          <Unplaced draft={draft} />
          {edited !== null && isConflict(save.error) ? (
            <Conflict
              newest={edited.newest}
              onShow={(newest) => {
                save.reset();
                edited.onShow(newest);
              }}
              onReplace={send}
            />
          ) : (
            <CommandErrorAlert
              command={edited === null ? "Starting the mission" : "Saving"}
              error={save.error}
              onClose={save.reset}
            />
          )}
          <Group gap="sm">
            <ReasonButton type="submit" size="md" reason={reason} loading={save.isPending}>
              {edited === null ? "Start mission" : "Save"}
            </ReasonButton>
            <Button
              variant="default"
              size="md"
              onClick={() => navigate(edited === null ? "/ui/missions" : missionPath(edited.base))}
            >
              Cancel
            </Button>
            {edited === null && mayNotSave === null && (
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

interface MoreProps {
  draft: Draft;
  error: string | undefined;
  onChange: (part: Partial<Draft>) => void;
}

/** What few missions need. */
function More({ draft, error, onChange }: MoreProps) {
  const [more, setMore] = useState(false);
  const opened = more || error !== undefined;
  return (
    <details className={classes.fold} open={opened} onToggle={(event) => setMore(event.currentTarget.open)}>
      <summary>More</summary>
      {opened && (
        <div className={classes.fields}>
          <NumberInput
            label="Priority"
            description="Of the missions that wait, the one with the highest number begins first."
            min={MIN_PRIORITY}
            max={MAX_PRIORITY}
            clampBehavior="none"
            allowDecimal={false}
            value={draft.priority}
            error={error}
            onChange={(priority) => onChange({ priority, refused: [] })}
          />
        </div>
      )}
    </details>
  );
}

/** Where the form shows what is wrong. */
const FIELDS = ["name", "priority", "battery", "steps"];

/** What the gateway has refused that has no field in the form. */
function Unplaced({ draft }: { draft: Draft }) {
  return draft.refused
    .filter(({ path }) => !FIELDS.some((each) => path === each || path.startsWith(`${each}.`)))
    .map(({ path, detail }) => (
      <Text key={path} size="sm" c="var(--mantine-color-error)">
        {path}: {detail}
      </Text>
    ));
}

/** A template that makes this mission. */
function templateOf(draft: Draft): Example {
  const { steps } = JSON.parse(bodyOf(draft, null)) as { steps: unknown[] };
  const { name, priority, battery } = draft;
  return { name, priority, battery, steps: escaped(steps) as unknown[] };
}
