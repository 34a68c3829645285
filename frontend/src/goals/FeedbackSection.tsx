import { Skeleton, Text } from "@mantine/core";
import { useState } from "react";
import { useSchemas } from "../actions/useActions";
import type { AnyGoal } from "../api/types";
import { isFinal, isTerminal } from "../store/goals";
import { Section } from "../ui/Section";
import { FeedbackPlots } from "./FeedbackPlots";
import { FeedbackRows } from "./FeedbackRows";
import { rowAt } from "./feedbackLog";
import { useWatched, useWatchTopic } from "./useGoalWatch";

const HEIGHT = 240;

/** The feedback of a goal as it comes: quantities over time, and the messages. */
export function FeedbackSection({ goal }: { goal: AnyGoal }) {
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
