import { isFinal, isTerminal, type LiveGoal } from "@dock-gateway/client";
import { CloseButton, Group, NativeSelect, Skeleton, Stack, Text } from "@mantine/core";
import { Suspense, useMemo, useState } from "react";
import { useSearchParams } from "react-router";
import { useSchemas } from "../actions/actions";
import { constantName, type JsonSchema, unitOf } from "../api/jsonSchema";
import { bandsOf } from "../goal/timeline";
import { lazyPart } from "../ui/lazyPart";
import { alike, COMPARED } from "../ui/numbers";
import { Section } from "../ui/Section";
import { formatElapsed } from "../ui/time";
import { FeedbackRows } from "./FeedbackRows";
import { FeedbackPlotSource, rowAt } from "./feedbackLog";
import { type FoundField, mostTelling, nodeOf, shortNames } from "./fields";
import { useTimeline, useWatched, useWatchTopic } from "./useGoalWatch";

/** The feedback of a goal as it comes: quantities over time, and the messages. */
export function FeedbackSection({ goal }: { goal: LiveGoal }) {
  const { watch } = useWatched();
  useWatchTopic("feedback");
  const past = useWatchTopic("past");
  const schema = useSchemas(goal.action_type).data?.feedback;
  /** The message that is shown in full. */
  const [chosen, setChosen] = useState<string | null>(null);
  const start = Date.parse(goal.created_at);
  const { log } = watch;
  if (log.rows.length === 0) {
    return (
      <Section title="Feedback">
        {past.loading ? <Skeleton height={HEIGHT} /> : <NoFeedback goal={goal} />}
      </Section>
    );
  }
  const pick = (moment: number) => setChosen(rowAt(log.rows, start + moment * 1000)?.id ?? null);
  return (
    <Section title="Feedback" aside={<Amount goal={goal} />}>
      <FeedbackPlots goal={goal} schema={schema} onPick={pick} />
      <FeedbackRows
        start={start}
        schema={schema}
        growing={!isTerminal(goal.status)}
        chosen={chosen}
        onChoose={setChosen}
      />
    </Section>
  );
}

function Amount({ goal }: { goal: LiveGoal }) {
  const { watch } = useWatched();
  const past = useWatchTopic("past");
  const shown = watch.log.rows.length;
  const all = Math.max(goal.feedback_count, shown);
  return (
    <Text size="sm" c="dimmed" data-testid="feedback-count">
      {all === 1 ? "1 message" : `${all} messages`}
      {past.loading && ", earlier ones are loading"}
      {watch.log.thinned && `, ${shown} of them shown here; the files have all`}
    </Text>
  );
}

function NoFeedback({ goal }: { goal: LiveGoal }) {
  return (
    <Text size="sm" c="dimmed">
      {isFinal(goal.status)
        ? "The action server sent no feedback, or the history does not keep it any more."
        : "No feedback yet. It appears here as the action server sends it."}
    </Text>
  );
}

const PlotStack = lazyPart(() => import("../ui/PlotStack"));

/** The heights of a single plot, and of each of several (px). */
const [HEIGHT, LOW_HEIGHT] = [240, 150];
const MAX_PLOTS = 6;
/** Each plotted quantity is one of these parameters of the address. */
const PLOT = "plot";

interface FeedbackPlotsProps {
  goal: LiveGoal;
  schema: JsonSchema | undefined;
  /** Clicked on a message, by when it came (s since the goal began). */
  onPick: (moment: number) => void;
}

/** The quantities that the address names over time, so that a link shows the same; the most telling one for none. */
function FeedbackPlots({ goal, schema, onPick }: FeedbackPlotsProps) {
  const { watch } = useWatched();
  const [parameters, setParameters] = useSearchParams();
  const all = watch.log.fields.all;
  const named = parameters.getAll(PLOT);
  const chosen = all.filter(({ name }) => named.includes(name)).slice(0, MAX_PLOTS);
  const telling = mostTelling(all);
  const shown = chosen.length > 0 || telling === null ? chosen : [telling];
  if (shown.length === 0) {
    return (
      <Text size="sm" c="dimmed">
        The feedback has no number that was measured, so there is nothing to plot.
      </Text>
    );
  }
  const names = shown.map(({ name }) => name);
  const choose = (next: readonly string[]) => {
    parameters.delete(PLOT);
    for (const name of next) parameters.append(PLOT, name);
    setParameters(parameters, { replace: true });
  };
  const others = all.map(({ name }) => name).filter((name) => !names.includes(name));
  return (
    <Stack gap="xs">
      <FieldPlots
        key={names.join("\n")}
        goal={goal}
        fields={shown}
        schema={schema}
        onPick={onPick}
        onRemove={(name) => choose(names.filter((each) => each !== name))}
      />
      <Group justify="space-between" align="flex-end" gap="xs">
        {others.length > 0 && (
          <NativeSelect
            aria-label="Add a plot"
            value=""
            disabled={names.length >= MAX_PLOTS}
            onChange={(event) => choose([...names, event.currentTarget.value])}
            data={[{ value: "", label: "Add a plot …" }, ...others]}
          />
        )}
        <Text size="sm" c="dimmed" visibleFrom="sm">
          Drag across a plot to zoom in; click to read the message.
        </Text>
      </Group>
    </Stack>
  );
}

interface FieldPlotsProps extends FeedbackPlotsProps {
  fields: readonly FoundField[];
  onRemove: (name: string) => void;
}

/** Plots of fields that stay the same. */
function FieldPlots({ goal, fields, schema, onPick, onRemove }: FieldPlotsProps) {
  const { watch, crosshair } = useWatched();
  const { entries } = useTimeline(goal);
  const start = Date.parse(goal.created_at);
  const { log } = watch;
  const digits = fields.map((field) => field.digits);
  // biome-ignore lint/correctness/useExhaustiveDependencies: the fields stay the same
  const source = useMemo(() => new FeedbackPlotSource(log, fields, start), [log, start]);
  // biome-ignore lint/correctness/useExhaustiveDependencies: the fields stay the same, but for their digits
  const lines = useMemo(() => {
    const names = shortNames(fields);
    return fields.map((field, index) => {
      const node = nodeOf(schema, field);
      const words = (value: number) => `${constantName(node, value) ?? ""} (${value})`;
      const named = node?.schema["x-constants"] === undefined ? {} : { words };
      return { label: names[index] ?? field.name, unit: unitOf(node), digits: field.digits, ...named };
    });
  }, [schema, ...digits]);
  const bands = useMemo(() => bandsOf(entries, start), [entries, start]);
  const height = fields.length === 1 ? HEIGHT : LOW_HEIGHT;
  const labels = fields.map(({ name, min, max, digits }, index) => {
    const unit = lines[index]?.unit ?? "";
    return `${name} over time, between ${alike(min, digits, COMPARED)} and ${alike(max, digits, COMPARED)} ${unit}`.trim();
  });
  const tools = fields.map(
    ({ name }) =>
      fields.length > 1 && (
        <CloseButton
          key={name}
          size="sm"
          aria-label={`Remove the plot of ${name}`}
          onClick={() => onRemove(name)}
        />
      ),
  );
  return (
    <Suspense fallback={<Skeleton height={fields.length * (height + 38)} />}>
      <PlotStack
        source={source}
        lines={lines}
        labels={labels}
        tools={tools}
        bands={bands}
        least={goal.finished_at === null ? 0 : (Date.parse(goal.finished_at) - start) / 1000}
        crosshair={crosshair}
        formatX={formatElapsed}
        onPick={onPick}
        height={height}
      />
    </Suspense>
  );
}
