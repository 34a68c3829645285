import { NumberInput, SimpleGrid, Stack, Text, TextInput } from "@mantine/core";
import { useState } from "react";
import { useLocation } from "react-router";
import { refusedFields } from "../../../actions/DraftFields";
import { EntryCard } from "../../../entries/EntryCard";
import { EntryForm } from "../../../entries/EntryForm";
import { useFleet, useFleetPart, useWhyNot } from "../../../fleet/context";
import { defaultRobot } from "../../../fleet/names";
import { Dialog } from "../../../ui/Dialog";
import { Empty } from "../../../ui/Empty";
import { ENTRY_BUTTON, ReasonButton } from "../../../ui/ReasonButton";
import { BatteryFields } from "../BatteryFields";
import { StepList } from "../StepList";
import { StoredPage } from "../StoredPage";
import { useStoredCommands } from "../stored";
import { stepsOf } from "../written";
import { refusedSteps } from "../wrong";
import { usedIn } from "./parameters";
import { RunTemplate } from "./RunTemplate";
import {
  bodyOf,
  draftOf,
  EXAMPLE,
  type Example,
  errorsOf,
  exampleDraft,
  type NamedTemplate,
  parameterWords,
  TEMPLATES,
  type TemplateDraft,
  useTemplates,
} from "./templates";

/** The template in the dialog; null for a new one, which may start from something. */
type Edited = { template: NamedTemplate | null; example?: Example };

/** Missions with parameters, to run and to change. A mission that is put together elsewhere comes as `location.state`. */
export default function TemplatesPage() {
  const query = useTemplates();
  const { state } = useLocation() as { state: Example | null };
  const reason = useWhyNot("PUT /mission-templates/{template_id}", query.data !== undefined);
  const mayRun = useWhyNot("POST /missions");
  const { remove } = useStoredCommands(TEMPLATES);
  const [edited, setEdited] = useState<Edited | null>(
    state === null ? null : { template: null, example: state },
  );
  const [run, setRun] = useState<NamedTemplate | null>(null);
  return (
    <>
      <StoredPage
        title="Templates"
        what="templates"
        button={
          <ReasonButton reason={reason} onClick={() => setEdited({ template: null })}>
            New template
          </ReasonButton>
        }
        query={query}
        empty={
          <Empty
            title="No templates"
            examples={
              <ReasonButton
                variant="default"
                reason={reason}
                onClick={() => setEdited({ template: null, example: EXAMPLE })}
              >
                Example: fetch from a shelf
              </ReasonButton>
            }
          >
            A template is a mission with parameters: “drive to $shelf” asks for the shelf each time. Run it
            here, by a schedule, or from a script. Each mission can be saved as a template from its form.
          </Empty>
        }
      >
        {(templates) =>
          templates.map((template) => (
            <EntryCard
              key={template.id}
              entry={template}
              words={[
                template.steps.length === 1 ? "One step" : `${template.steps.length} steps`,
                parameterWords(template),
              ]}
              control={null}
              buttons={
                <ReasonButton
                  {...ENTRY_BUTTON}
                  variant="filled"
                  reason={mayRun}
                  aria-label={`Run ${template.name}`}
                  onClick={() => setRun(template)}
                >
                  Run
                </ReasonButton>
              }
              reason={reason}
              onEdit={() => setEdited({ template })}
              remove={remove}
              removal="Missions that were made of it go on. Schedules that use it queue no more missions."
            >
              {null}
            </EntryCard>
          ))
        }
      </StoredPage>
      <Dialog
        opened={edited !== null}
        onClose={() => setEdited(null)}
        title={edited?.template ? `Edit ${edited.template.name}` : "New template"}
        size="xl"
      >
        {edited !== null && (
          <TemplateForm {...edited} templates={query.data ?? []} onDone={() => setEdited(null)} />
        )}
      </Dialog>
      <Dialog opened={run !== null} onClose={() => setRun(null)} title={`Run ${run?.name ?? ""}`}>
        {run !== null && <RunTemplate template={run} onCancel={() => setRun(null)} />}
      </Dialog>
    </>
  );
}

interface TemplateFormProps extends Edited {
  templates: readonly NamedTemplate[];
  onDone: () => void;
}

function TemplateForm({ template, example, templates, onDone }: TemplateFormProps) {
  const { store } = useFleet();
  const robot = useFleetPart("robots", defaultRobot);
  const { save } = useStoredCommands(TEMPLATES);
  return (
    <EntryForm
      noun="template"
      entry={template}
      draftOf={(entry: NamedTemplate | null) => draftOf(entry, store.gatewayNow())}
      example={example && exampleDraft(example, store.gatewayNow())}
      entries={templates}
      placeholder="Fetch"
      maxName={60}
      errorsOf={errorsOf}
      bodyOf={(draft, by) => bodyOf(draft, by)}
      save={save}
      refused={({ steps }, error) => ({ steps: refusedSteps(steps, refusedFields(error)) })}
      onSaved={onDone}
      onCancel={onDone}
    >
      {(draft, errors, change) => (
        <>
          <Text size="sm" c="dimmed">
            Write “$shelf” for a place or a text, and it is a parameter; other values can be one in a step
            that is written as JSON.
          </Text>
          <StepList
            steps={draft.steps}
            robot={robot}
            tried={errors.steps !== undefined}
            error={errors.steps}
            written
            onSteps={(edit) => change((before) => ({ steps: edit(before.steps) }))}
          />
          <Parameters draft={draft} onChange={(parameters) => change({ parameters })} />
          <BatteryFields
            battery={draft.battery}
            errors={errors.battery ?? []}
            onChange={(battery) => change({ battery })}
          />
          <NumberInput
            label="Priority"
            min={0}
            max={100}
            clampBehavior="none"
            allowDecimal={false}
            value={draft.priority}
            error={errors.priority}
            onChange={(priority) => change({ priority })}
          />
        </>
      )}
    </EntryForm>
  );
}

interface ParametersProps {
  draft: TemplateDraft;
  onChange: (parameters: TemplateDraft["parameters"]) => void;
}

/** What is known of each parameter that the steps use. */
function Parameters({ draft: { steps, parameters }, onChange }: ParametersProps) {
  const names = usedIn(stepsOf(steps));
  if (names.length === 0)
    return (
      <Text size="sm" c="dimmed">
        No parameters: each mission of it is the same.
      </Text>
    );
  return (
    <Stack gap="xs" role="group" aria-label="Parameters">
      {names.map((name) => {
        const own = parameters[name] ?? { description: "", initial: "" };
        const set = (part: Partial<typeof own>) => onChange({ ...parameters, [name]: { ...own, ...part } });
        return (
          <SimpleGrid key={name} cols={{ base: 1, xs: 2 }} spacing="sm">
            <TextInput
              label={`What ${name} is`}
              maxLength={200}
              value={own.description}
              onChange={(event) => set({ description: event.currentTarget.value })}
            />
            <TextInput
              label={`Default of ${name}`}
              placeholder="None: it has to be given"
              value={own.initial}
              onChange={(event) => set({ initial: event.currentTarget.value })}
            />
          </SimpleGrid>
        );
      })}
    </Stack>
  );
}
