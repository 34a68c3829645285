import { Anchor, Stack } from "@mantine/core";
import { Link } from "react-router";
import { Command } from "../ui/Command";
import { ThingList } from "./ThingList";
import { TypeNames } from "./TypeNames";
import type { GraphAction } from "./types";
import type { ChangeView } from "./useView";

/** Who serves an action, who sends goals to it, and the ways on. */
export function ActionDetails({ action, change }: { action: GraphAction; change: ChangeView }) {
  const { name, types, servers, clients } = action;
  return (
    <Stack gap="md">
      <TypeNames types={types} />
      <ThingList
        title="Servers"
        kind="node"
        names={servers}
        absent="Nobody: goals would not be answered."
        change={change}
      />
      <ThingList title="Clients" kind="node" names={clients} absent="Nobody." change={change} />
      <Stack gap={4}>
        <Anchor component={Link} to={`/ui/actions${name}`} size="sm">
          Send a goal
        </Anchor>
        <Anchor component={Link} to={`/ui/goals?${new URLSearchParams({ action: name })}`} size="sm">
          Its goals
        </Anchor>
      </Stack>
      <Command line={`curl ${window.location.origin}/actions${name}`} what="the command for a terminal" />
    </Stack>
  );
}
