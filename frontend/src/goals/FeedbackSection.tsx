import { Group, NativeSelect, Skeleton, Stack, Text } from "@mantine/core";
import { Suspense, useMemo } from "react";
import { useSearchParams } from "react-router";
import { useSchemas } from "../actions/useActions";
import type { AnyGoal } from "../api/types";
import { isFinal } from "../store/goals";
import { constantName, type JsonSchema, unitOf } from "../ui/jsonSchema";
import { lazyPart } from "../ui/lazyPart";
import { alike } from "../ui/numbers";
import { Section } from "../ui/Section";
import { formatElapsed } from "../ui/time";
import { FeedbackRows } from "./FeedbackRows";
import { FeedbackPlotSource } from "./feedbackPlot";
import { type FoundField, mostTelling, nodeOf } from "./fields";
import { useWatched, useWatchTopic } from "./useGoalWatch";

const LinePlot = lazyPart(() => import("../ui/LinePlot"));

const HEIGHT = 240;

/** The feedback of a goal as it comes: one field over time, and the messages. */
export function FeedbackSection({ goal }: { goal: AnyGoal }) {
  const { watch } = useWatched();
  useWatchTopic("feedback");
  const past = useWatchTopic("past");
  const schema = useSchemas(goal.action_type).data?.feedback;
  const { log } = watch;
  if (log.rows.length === 0) {
    return (
      <Section title="Feedback">
        {past.loading ? <Skeleton height={HEIGHT} /> : <NoFeedback goal={goal} />}
      </Section>
    );
  }
  return (
    <Section title="Feedback" aside={<Amount goal={goal} />}>
      <PlottedField start={Date.parse(goal.created_at)} schema={schema} />
      <FeedbackRows start={Date.parse(goal.created_at)} schema={schema} />
    </Section>
  );
}

function Amount({ goal }: { goal: AnyGoal }) {
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

function NoFeedback({ goal }: { goal: AnyGoal }) {
  return (
    <Text size="sm" c="dimmed">
      {isFinal(goal.status)
        ? "The action server sent no feedback, or the history does not keep it any more."
        : "No feedback yet. It appears here as the action server sends it."}
    </Text>
  );
}

interface PlottedFieldProps {
  /** When the goal began (ms). */
  start: number;
  schema: JsonSchema | undefined;
}

/** The plot of the field that the address names, so that a link shows the same. */
function PlottedField({ start, schema }: PlottedFieldProps) {
  const { watch } = useWatched();
  const [parameters, setParameters] = useSearchParams();
  const fields = watch.log.fields.all;
  const named = fields.find(({ name }) => name === parameters.get("plot"));
  const name = (named ?? mostTelling(fields))?.name;
  const field = fields.find((each) => each.name === name);
  if (field === undefined) {
    return (
      <Text size="sm" c="dimmed">
        The feedback has no number that was measured, so there is nothing to plot.
      </Text>
    );
  }
  const choose = (plot: string) => {
    parameters.set("plot", plot);
    setParameters(parameters, { replace: true });
  };
  return (
    <Stack gap="xs">
      <Group justify="space-between" align="flex-end">
        <NativeSelect
          label="Plot"
          value={field.name}
          onChange={(event) => choose(event.currentTarget.value)}
          data={fields.map((each) => each.name)}
        />
        <Text size="sm" c="dimmed" visibleFrom="sm">
          Drag across the plot to zoom in.
        </Text>
      </Group>
      <FieldPlot key={field.name} field={field} start={start} schema={schema} />
    </Stack>
  );
}

function FieldPlot({ field, start, schema }: PlottedFieldProps & { field: FoundField }) {
  const { log } = useWatched().watch;
  const { name, digits } = field;
  const source = useMemo(() => {
    const found = log.fields.all.find((each) => each.name === name);
    return new FeedbackPlotSource(log, found ?? { name, path: [] }, start);
  }, [log, name, start]);
  const lines = useMemo(() => {
    const node = nodeOf(schema, source.field);
    const words = (value: number) => `${constantName(node, value) ?? ""} (${value})`;
    const named = node?.schema["x-constants"] === undefined ? {} : { words };
    return [{ label: name, unit: unitOf(node), digits, ...named }];
  }, [schema, source, name, digits]);
  const unit = lines[0]?.unit ?? "";
  return (
    <Suspense fallback={<Skeleton height={HEIGHT + 34} />}>
      <LinePlot
        source={source}
        lines={lines}
        xLabel="Since the start"
        formatX={formatElapsed}
        label={`${name} over time, between ${alike(field.min, digits)} and ${alike(field.max, digits)} ${unit}`}
        height={HEIGHT}
      />
    </Suspense>
  );
}
