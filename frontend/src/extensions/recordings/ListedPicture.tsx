import { isTerminal } from "@dock-gateway/client";
import { keepPreviousData } from "@tanstack/react-query";
import { ofSites } from "../../api/places";
import type { Places } from "../../extension/extension";
import { useFleet } from "../../fleet/context";
import { useAnswer } from "../../ui/requests";
import { GoalPicture } from "./GoalPicture";
import { picturedGoals } from "./requests";

/** The gateway is asked for the pictures of so many goals at once. */
const MAX_ASKED = 100;

/** The last picture of a listed goal, where it has one: one request for the newest of the list that have ended. */
export function ListedPicture({ goal: { goal_id }, listed }: Places["listedGoal"]) {
  const { http } = useFleet();
  const ids = listed.flatMap((goal) => (isTerminal(goal.status) ? [goal.goal_id] : [])).slice(0, MAX_ASKED);
  const { data } = useAnswer({
    queryKey: ["pictured", ...ids],
    queryFn: () => picturedGoals(http, ids),
    // Recordings are at the sites.
    enabled: ids.length > 0 && !ofSites(),
    placeholderData: keepPreviousData,
  });
  return data?.includes(goal_id) ? <GoalPicture goalId={goal_id} small /> : null;
}
