import { Anchor, Stack } from "@mantine/core";
import { Link } from "react-router";
import { ServedDetails } from "./ServedDetails";
import type { GraphAction } from "./types";
import type { ChangeView } from "./useView";

/** Who serves an action, who sends goals to it, and the ways on. */
export function ActionDetails({ action, change }: { action: GraphAction; change: ChangeView }) {
  const { name, types, servers, clients } = action;
  return (
    <ServedDetails
      types={types}
      servers={servers}
      unserved="Nobody: goals would not be answered."
      clients={clients}
      line={`curl ${window.location.origin}/actions${name}`}
      change={change}
    >
      <Stack gap={4}>
        <Anchor component={Link} to={`/ui/actions${name}`} size="sm">
          Send a goal
        </Anchor>
        <Anchor component={Link} to={`/ui/goals?${new URLSearchParams({ action: name })}`} size="sm">
          Its goals
        </Anchor>
      </Stack>
    </ServedDetails>
  );
}
