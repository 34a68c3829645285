import {
  Alert,
  Checkbox,
  NativeSelect,
  NumberInput,
  SegmentedControl,
  SimpleGrid,
  TextInput,
} from "@mantine/core";
import { refusedFields } from "../../../actions/DraftFields";
import { EntryForm } from "../../../entries/EntryForm";
import { useFleet, useFleetPart } from "../../../fleet/context";
import { defaultRobot } from "../../../fleet/names";
import { TimesOfDayFields } from "../../../ui/TimesOfDayFields";
import { StepList } from "../StepList";
import { useStoredCommands } from "../stored";
import { TakerField, useExampleRobot } from "../TakerField";
import { ArgumentFields } from "../templates/ArgumentFields";
import { useTemplates } from "../templates/templates";
import { refusedSteps } from "../wrong";
import { bodyOf, draftOf, errorsOf, type NamedSchedule, SCHEDULES, type ScheduleDraft } from "./schedules";

const MAX_TIMES = 24;

interface ScheduleFormProps {
  /** Null for a new one, which is on. */
  schedule: NamedSchedule | null;
  schedules: readonly NamedSchedule[];
  onDone: () => void;
}

/** Adds or changes a schedule. */
export function ScheduleForm({ schedule, schedules, onDone }: ScheduleFormProps) {
  const { store } = useFleet();
  const { save } = useStoredCommands(SCHEDULES);
  const { data: templates = [] } = useTemplates();
  const robot = useFleetPart("robots", defaultRobot);
  return (
    <EntryForm
      noun="schedule"
      entry={schedule}
      draftOf={(entry: NamedSchedule | null) => draftOf(entry, robot, store.gatewayNow())}
      example={schedule === null && templates[0] !== undefined ? { template: templates[0].id } : undefined}
      entries={schedules}
      placeholder="Night round"
      maxName={60}
      errorsOf={(draft) => errorsOf(draft, templates)}
      bodyOf={(draft, by, replaced) => bodyOf(draft, templates, replaced?.enabled ?? true, by)}
      save={save}
      refused={({ steps }, error) => ({
        steps: refusedSteps(steps, refusedFields(error), "mission.steps"),
      })}
      onSaved={onDone}
      onCancel={onDone}
    >
      {(draft, errors, change) => (
        <>
          <TakerField robot={draft.robot} group={draft.group} onTaker={(taker) => change(taker)} />
          <MissionFields draft={draft} errors={errors} onChange={change} />
          <SegmentedControl
            aria-label="When"
            data={[
              { value: "daily", label: "Times of day" },
              { value: "every", label: "Every …" },
              { value: "once", label: "Once" },
            ]}
            value={draft.when}
            onChange={(when) => change({ when: when as ScheduleDraft["when"] })}
          />
          <TimeFields draft={draft} errors={errors} onChange={change} />
          <Checkbox
            label="Also while its last mission has not ended"
            description="Otherwise that time is skipped."
            checked={draft.queues}
            onChange={(event) => change({ queues: event.currentTarget.checked })}
          />
          {(schedule === null || schedule.enabled) && (
            <Alert color="orange" title="The robot moves by itself">
              What you save applies at once. Check that its way is clear at these times.
            </Alert>
          )}
        </>
      )}
    </EntryForm>
  );
}

interface FieldsProps {
  draft: ScheduleDraft;
  errors: Partial<Record<keyof ScheduleDraft, string>>;
  onChange: (part: Partial<ScheduleDraft> | ((before: ScheduleDraft) => Partial<ScheduleDraft>)) => void;
}

/** A template with its parameters, or steps. */
function MissionFields({ draft, errors, onChange }: FieldsProps) {
  const { data: templates = [] } = useTemplates();
  const robot = useExampleRobot(draft);
  const chosen = templates.find(({ id }) => id === draft.template);
  const gone = draft.template !== "" && chosen === undefined;
  return (
    <>
      {(templates.length > 0 || gone) && (
        <NativeSelect
          label="Mission"
          value={draft.template}
          error={errors.template}
          onChange={(event) => onChange({ template: event.currentTarget.value })}
          data={[
            ...templates.map(({ id, name }) => ({ value: id, label: name })),
            ...(gone ? [{ value: draft.template, label: draft.template }] : []),
            { value: "", label: "Steps, put together here" },
          ]}
        />
      )}
      {chosen !== undefined && (
        <ArgumentFields
          template={chosen}
          typed={draft.typed}
          tried={errors.typed !== undefined}
          onType={(typed) => onChange({ typed })}
        />
      )}
      {draft.template === "" && (
        <StepList
          steps={draft.steps}
          robot={robot}
          tried={errors.steps !== undefined}
          error={errors.steps}
          onSteps={(edit) => onChange((before) => ({ steps: edit(before.steps) }))}
        />
      )}
    </>
  );
}

/** When it is due. */
function TimeFields({ draft, errors, onChange }: FieldsProps) {
  if (draft.when === "every")
    return (
      <NumberInput
        label="Every"
        suffix=" min"
        min={1}
        clampBehavior="none"
        allowDecimal={false}
        description="Counted from when it is saved."
        value={draft.minutes}
        error={errors.minutes}
        onChange={(minutes) => onChange({ minutes })}
      />
    );
  if (draft.when === "once")
    return (
      <SimpleGrid cols={{ base: 1, xs: 2 }} spacing="sm">
        <TextInput
          label="Day"
          type="date"
          value={draft.day}
          error={errors.day}
          onChange={(event) => onChange({ day: event.currentTarget.value })}
        />
        <TextInput
          label="Time"
          placeholder="06:00"
          maxLength={5}
          value={draft.clock}
          error={errors.day !== undefined}
          onChange={(event) => onChange({ clock: event.currentTarget.value })}
        />
      </SimpleGrid>
    );
  return <TimesOfDayFields draft={draft} errors={errors} maxTimes={MAX_TIMES} onChange={onChange} />;
}
