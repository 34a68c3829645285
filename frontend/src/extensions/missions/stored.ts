import type { Http } from "@dock-gateway/client";
import { useQueryClient } from "@tanstack/react-query";
import type { Base } from "../../api/version";
import { useFleet, useFleetLive } from "../../fleet/context";
import { useAnswer, useCommand } from "../../ui/requests";

/** The requests about something that people store for missions. */
export interface Stored<Entry, Body> {
  key: readonly string[];
  list: (http: Http) => Promise<Entry[]>;
  put: (http: Http, id: string, body: Body, base: Base) => Promise<Entry>;
  remove: (http: Http, entry: Entry) => Promise<void>;
}

/** All that is stored. @param refetchMs How often it is asked for. */
export function useStored<Entry, Body>(
  { key, list }: Stored<Entry, Body>,
  refetchMs: number | false = false,
) {
  const { http } = useFleet();
  const enabled = useFleetLive();
  return useAnswer({ queryKey: key, queryFn: () => list(http), enabled, refetchInterval: refetchMs });
}

/** What changes it. */
export function useStoredCommands<Entry, Body>({ key, put, remove }: Stored<Entry, Body>) {
  const { http } = useFleet();
  const client = useQueryClient();
  const changed = () => client.invalidateQueries({ queryKey: key });
  return {
    save: useCommand(({ id, body, base }: { id: string; body: Body; base: Base }) =>
      put(http, id, body, base).finally(changed),
    ),
    remove: useCommand((entry: Entry) => remove(http, entry).finally(changed)),
  };
}

/** With its id for a name that it does not have. */
export function named<Entry extends { id: string; name: string | null }>(
  entry: Entry,
): Entry & { name: string } {
  return { ...entry, name: entry.name ?? entry.id };
}

/** By name. */
export function sorted<Entry extends { name: string }>(entries: readonly Entry[]): Entry[] {
  return [...entries].sort((one, other) => one.name.localeCompare(other.name));
}
