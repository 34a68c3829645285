import type { Verb } from "../api/client";
import type { Goal } from "../api/types";
import { useTopicPart } from "./context";

/** Which of the page's two actions a goal is on. */
export function useVerbOf(): (goal: Pick<Goal, "action_name">) => Verb {
  const undock = useTopicPart("undockServer", (server) => server?.action_name);
  return (goal) => (goal.action_name === undock ? "undock" : "dock");
}
