import { Stack } from "@mantine/core";
import type { ReactNode } from "react";
import { Command } from "../ui/Command";
import { ThingList } from "./ThingList";
import { TypeNames } from "./TypeNames";
import type { ChangeView } from "./useView";

interface ServedDetailsProps {
  types: readonly string[];
  servers: readonly string[];
  /** What it means that there are none. */
  unserved: string;
  clients: readonly string[];
  /** How it is used from a terminal. */
  line: string;
  change: ChangeView;
  /** The ways on. */
  children?: ReactNode;
}

/** Who serves something, and who asks for it: a service or an action. */
export function ServedDetails(props: ServedDetailsProps) {
  const { types, servers, unserved, clients, line, change, children } = props;
  return (
    <Stack gap="md">
      <TypeNames types={types} />
      <ThingList title="Servers" kind="node" names={servers} absent={unserved} change={change} />
      <ThingList title="Clients" kind="node" names={clients} absent="Nobody." change={change} />
      {children}
      <Command line={line} what="the command for a terminal" />
    </Stack>
  );
}
