import { Skeleton } from "@mantine/core";
import { Navigate, useParams } from "react-router";
import { createGoalsApi } from "../../api/goals";
import { useFleet } from "../../fleet/context";
import { goalPath } from "../../fleet/names";
import { Trouble } from "../../ui/errors";
import { useAnswer } from "../../ui/requests";
import { PageTitle } from "../../ui/Section";

/** At a hub: leads to the goal's page at its site. */
export default function GoalAtSite() {
  const { goalId = "" } = useParams();
  const { http } = useFleet();
  const { data, error, refetch } = useAnswer({
    queryKey: ["goal", goalId],
    queryFn: () => createGoalsApi(http).goal(goalId),
  });
  if (data !== undefined) return <Navigate to={goalPath(goalId, data.action_name)} replace />;
  return (
    <>
      <PageTitle title="Goal" />
      {error === null && <Skeleton height={200} role="status" aria-label="The goal is loading" />}
      <Trouble what="The goal could not be loaded" error={error} onRetry={() => void refetch()} />
    </>
  );
}
