import { useQuery } from "@tanstack/react-query";
import { useState } from "react";
import type { ActionServer } from "../api/types";
import { useLive, useServices } from "../store/context";

const REFETCH_MS = 30_000;

export interface Docks {
  /** The names of all docks, the default one first; none where the docking server knows no docks by name. */
  all: string[];
  /** The dock that a goal without a name is for; null where that is not known. */
  standard: string | null;
  /** The dock to drive to; undefined where there are none. */
  chosen: string | undefined;
  choose: (name: string) => void;
}

/** The docks of a robot, and the one that is chosen: the default one unless the user has chosen another. */
export function useDocks(server: ActionServer | null): Docks {
  const { gateway, robot } = useServices();
  const live = useLive();
  const [wanted, choose] = useState<string | null>(null);
  const { data } = useQuery({
    queryKey: ["docks", robot, server?.action_name],
    queryFn: gateway.docks,
    refetchInterval: REFETCH_MS,
    enabled: live && server?.available === true,
  });
  const names = data?.docks.map((dock) => dock.dock_id) ?? [];
  const standard = data?.default ?? null;
  const first = names.find((name) => name === standard) ?? names[0];
  const all = first === undefined ? [] : [first, ...names.filter((name) => name !== first)];
  return { all, standard, chosen: all.find((name) => name === wanted) ?? first, choose };
}
