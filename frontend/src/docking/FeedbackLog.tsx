import { Text } from "@mantine/core";
import { useState } from "react";
import { batteryIn, summarize } from "../battery/words";
import { useTopic, useTopicPart } from "../store/context";
import { Time } from "../ui/Time";
import classes from "./docking.module.css";

/** The latest feedback of a goal as it comes, newest first; folded until somebody wants to read it. */
export function FeedbackLog({ goalId }: { goalId: string }) {
  const [open, setOpen] = useState(false);
  const any = useTopicPart("feedback", (events) => events.some((event) => event.goal_id === goalId));
  if (!any) return null;
  return (
    <details
      className={classes.log}
      data-testid="feedback-log"
      onToggle={(event) => setOpen(event.currentTarget.open)}
    >
      <summary>Feedback as it comes</summary>
      {open && <Messages goalId={goalId} />}
    </details>
  );
}

function Messages({ goalId }: { goalId: string }) {
  const messages = useTopic("feedback").filter((event) => event.goal_id === goalId);
  return (
    <ol>
      {messages.map(({ id, time, feedback }) => (
        <li key={id}>
          <Text span size="sm" c="dimmed" className="tabular">
            <Time value={time} />
          </Text>{" "}
          <Text span size="sm" className="tabular">
            {wordsOf(feedback)}
          </Text>
        </li>
      ))}
    </ol>
  );
}

/** A battery state in words; the fields of any other feedback as JSON. */
function wordsOf(feedback: object): string {
  const battery = batteryIn(feedback, "current_battery_state");
  return battery === null ? JSON.stringify(feedback) : summarize(battery);
}
