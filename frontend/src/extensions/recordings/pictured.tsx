import { type GoalStatus, isTerminal } from "@dock-gateway/client";
import { keepPreviousData } from "@tanstack/react-query";
import { type ReactNode, useMemo } from "react";
import { ofSites } from "../../api/places";
import { useFleet } from "../../fleet/context";
import { useAnswer } from "../../ui/requests";
import { GoalPicture } from "./GoalPicture";
import { picturedGoals } from "./requests";

/** The gateway is asked for the pictures of so many goals at once. */
const MAX_ASKED = 100;

/** The last pictures of listed goals, of the newest that have ended: one request for all. */
export function useGoalPictures(
  goals: readonly { goal_id: string; status: GoalStatus }[],
): ReadonlyMap<string, ReactNode> {
  const { http } = useFleet();
  const ids = goals
    .filter(({ status }) => isTerminal(status))
    .slice(0, MAX_ASKED)
    .map(({ goal_id }) => goal_id);
  const { data } = useAnswer({
    queryKey: ["pictured", ...ids],
    queryFn: () => picturedGoals(http, ids),
    // Recordings are at the sites.
    enabled: ids.length > 0 && !ofSites(),
    placeholderData: keepPreviousData,
  });
  return useMemo(
    () => new Map((data ?? []).map((id) => [id, <GoalPicture key={id} goalId={id} small />])),
    [data],
  );
}
