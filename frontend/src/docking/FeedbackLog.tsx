import { Text } from "@mantine/core";
import type { Goal } from "../api/types";
import { summarize } from "../battery/words";
import { useTopic } from "../store/context";
import { Time } from "../ui/Time";
import classes from "./docking.module.css";

/** The latest feedback of a goal as it comes, newest first; folded until somebody wants to read it. */
export function FeedbackLog({ goal }: { goal: Goal }) {
  const messages = useTopic("feedback").filter((event) => event.goal_id === goal.goal_id);
  if (messages.length === 0) return null;
  return (
    <details className={classes.log} data-testid="feedback-log">
      <summary>Feedback as it comes</summary>
      <ol>
        {messages.map(({ id, time, feedback }) => (
          <li key={id}>
            <Text span size="sm" c="dimmed" className="tabular">
              <Time value={time} />
            </Text>{" "}
            <Text span size="sm" className="tabular">
              {summarize(feedback.current_battery_state)}
            </Text>
          </li>
        ))}
      </ol>
    </details>
  );
}
