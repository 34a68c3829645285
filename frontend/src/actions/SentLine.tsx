import { Anchor } from "@mantine/core";
import { Link } from "react-router";
import type { AnyGoal } from "../api/types";

/** What became of the goal that was sent from here. */
export function SentLine({ goal }: { goal: AnyGoal | null }) {
  if (goal === null) return null;
  return (
    <span data-testid="sent">
      Sent: the action server took{" "}
      <Anchor component={Link} to={`/ui/goals/${goal.goal_id}`} inherit>
        goal {goal.goal_id.slice(0, 8)}
      </Anchor>
      .
    </span>
  );
}
