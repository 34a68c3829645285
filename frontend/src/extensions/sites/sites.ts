import { useFleet } from "../../fleet/context";
import { byName } from "../../fleet/names";
import { useAnswer } from "../../ui/requests";
import { listSites, type Site } from "./requests";

const EVERY_MS = 2000;

export const SITES_KEY = ["sites"] as const;

/** The sites of the hub, asked for again and again. */
export function useSites() {
  const { http } = useFleet();
  return useAnswer({
    queryKey: SITES_KEY,
    queryFn: () => listSites(http),
    refetchInterval: EVERY_MS,
  });
}

export const STATE_WORDS: Record<Site["state"], string> = {
  connected: "Connected",
  unreachable: "Unreachable",
  refused: "Refused",
};

const CODES: Record<string, string> = {
  site_name_taken: "another gateway wanted this name",
  site_connected_elsewhere: "a second process of this gateway wanted to connect",
  version_refused: "its version is too far from the hub's",
  malformed: "a message could not be read",
  too_large: "a message was too large",
  too_many_hellos: "the site said hello too often",
  invalid_identity: "the site did not accept the hub's signature: check its hub_public_keys",
};

/** Why messages were refused, in words, and how often; the most frequent first. */
export function refusalWords({ refused }: Pick<Site, "refused">): string[] {
  return Object.entries(refused)
    .sort(([, one], [, other]) => other - one)
    .map(([code, count]) => `${CODES[code] ?? code.replaceAll("_", " ")} (${count}×)`);
}

/** A clock that is this far off is worth a word (s). */
const CLOCK_S = 2;

/** How far the clock of a site is off; null where that does not matter. */
export function clockWords({ clock_offset_s: offset }: Pick<Site, "clock_offset_s">): string | null {
  if (offset === null || Math.abs(offset) < CLOCK_S) return null;
  return `Its clock is ${Math.round(Math.abs(offset))} s ${offset > 0 ? "ahead of" : "behind"} the hub's`;
}

/** `3 robots, 1 goal, 2 alerts`; what there is none of is left out but for robots. */
export function countWords({ robots, goals_running, alerts }: Site): string {
  const count = (number: number, one: string) => (number === 1 ? `1 ${one}` : `${number} ${one}s`);
  const parts = [count(robots, "robot")];
  if (goals_running > 0) parts.push(count(goals_running, "goal"));
  if (alerts > 0) parts.push(count(alerts, "alert"));
  return parts.join(", ");
}

/** Those that need eyes first: not connected, stopped, with alerts; then by name. */
export function urgentSites(sites: readonly Site[]): Site[] {
  const rank = ({ state, stop, alerts }: Site) =>
    state !== "connected" ? 0 : stop.latched ? 1 : alerts > 0 ? 2 : 3;
  return [...sites].sort((a, b) => rank(a) - rank(b) || byName(a.name, b.name));
}

/** Where the dashboard of a site begins. */
export function sitePath(site: string): string {
  return `/sites/${site}/`;
}
