import type { ActionInfo } from "@dock-gateway/client";
import { useMemo } from "react";
import { createActionsApi, goalsPath } from "../api/actions";
import { ofSites } from "../api/places";
import { whyForbidden } from "../api/session";
import { NOT_CONNECTED, useFleet } from "../fleet/context";
import { isUnder } from "../fleet/names";
import type { HeldStop } from "../stop/held";
import { useAnswer } from "../ui/requests";

/** How often the graph is looked at. */
const LOOK_EVERY_MS = 2000;

export function useActionsApi() {
  const { http } = useFleet();
  return useMemo(() => createActionsApi(http), [http]);
}

/** Every action on the graph, by name; looked up again while the page is seen. */
export function useActions() {
  const api = useActionsApi();
  return useAnswer({
    queryKey: ["actions"],
    queryFn: () => api.list().then(byName),
    refetchInterval: LOOK_EVERY_MS,
    enabled: !ofSites(), // the actions are those of its sites
  });
}

/** The messages of an action type. */
export function useSchemas(type: string) {
  const api = useActionsApi();
  return useAnswer({
    queryKey: ["interface", type],
    queryFn: () => api.schemas(type),
    staleTime: Number.POSITIVE_INFINITY,
  });
}

function byName(actions: ActionInfo[]): ActionInfo[] {
  return actions.sort((a, b) => a.action_name.localeCompare(b.action_name));
}

interface Circumstances {
  live: boolean;
  action: ActionInfo | null;
  stopped: boolean;
  sending: boolean;
}

/** Why no goal can be sent; null where one can. */
export function whyNotSend({ live, action, stopped, sending }: Circumstances): string | null {
  const forbidden = whyForbidden("POST /actions/{name}/goals");
  if (forbidden !== null) return forbidden;
  if (!live) return NOT_CONNECTED;
  if (stopped) return "The robot is stopped. Release the stop first.";
  if (sending) return "A goal was sent. The action server has not answered yet.";
  if (action?.available !== true) return "No action server for this action. Start it first.";
  return null;
}

/** Whether one of these stops holds an action. */
export function isHeld(action: string, stops: readonly HeldStop[]): boolean {
  return stops.some(({ robot, holds }) => [robot, ...holds].some((held) => isUnder(action, held)));
}

/** The command line that sends a goal, for any POSIX shell. */
export function sendLine(address: string, action: string, body: string): string {
  return `curl -sX POST ${address}${goalsPath(action)} -H 'Content-Type: application/json' -d ${quoted(body)}`;
}

/** A word of a shell that stands for this text, whatever is in it. */
export function quoted(text: string): string {
  return `'${text.replaceAll("'", "'\\''")}'`;
}
