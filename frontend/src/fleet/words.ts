import type { Robot } from "@dock-gateway/client";
import { serverName } from "../api/places";
import { formatDuration } from "../ui/time";

/** The namespaces of the robots that are there. */
export function namesThere(robots: ReadonlyMap<string, Robot>): string[] {
  return [...robots.values()].filter(isThere).map(({ name }) => name);
}

/** Whether anything of a robot was ever heard: the configured one is listed from the start. */
export function isThere({ battery, battery_publisher, dock, undock, goals, last_goal }: Robot): boolean {
  return (
    battery.state !== null ||
    battery_publisher.active ||
    dock?.available === true ||
    undock?.available === true ||
    goals.length > 0 ||
    last_goal !== null
  );
}

export function placeWords(docked: boolean | null): string {
  if (docked === null) return "Unknown";
  return docked ? "Docked" : "Not docked";
}

/**
 * How a robot can be reached. `unreachable`: nothing of it answers, neither a docking server nor a battery that was heard
 * before. `gone`: its battery is heard, but its docking servers have left the graph. `stale`: its docking servers answer,
 * but its battery is heard no more. `away`: its site is not connected, and what is known of the robot is as it was then.
 */
export type Link =
  | "away"
  | "connected"
  | "stale"
  | "silent"
  | "duplicate"
  | "gone"
  | "battery"
  | "unreachable";

export function linkOf({ dock, undock, battery, site_state = "connected" }: Linked): Link {
  if (site_state !== "connected") return "away";
  const servers = [dock, undock].filter((server) => server !== null);
  const available = servers.filter((server) => server.available);
  if (available.some((server) => server.duplicate)) return "duplicate";
  const answering = available.filter((server) => server.answering).length;
  const batteryEverHeard = battery.state !== null;
  const batteryLost = batteryEverHeard && battery.stale;
  if (answering > 0) return answering < available.length ? "silent" : batteryLost ? "stale" : "connected";
  if (batteryLost) return "unreachable";
  if (available.length > 0) return "silent";
  if (!batteryEverHeard) return "unreachable";
  return servers.length > 0 ? "gone" : "battery";
}

interface Linked extends Pick<Robot, "dock" | "undock" | "battery"> {
  /** At a hub: whether the robot's site is connected. */
  site_state?: string;
}

/** Whether no command would reach the robot's docking servers. */
export function isUnreachable(robot: Robot): boolean {
  const link = linkOf(robot);
  return link === "unreachable" || link === "gone" || link === "silent" || link === "away";
}

export const LINK_WORDS: Record<Link, string> = {
  connected: "Connected",
  stale: "No battery state",
  silent: "Silent",
  duplicate: "Two servers",
  gone: "No docking server",
  battery: "Battery only",
  unreachable: "Unreachable",
  away: "Site unreachable",
};

const LINK_HINTS: Record<Link, string> = {
  away: "The server does not reach its site. What is shown is what was last known; the robot may have moved since.",
  connected: "Its action servers answer, and its battery is heard where it has one.",
  stale:
    "Its action servers answer, but its battery is heard no more: the robot may be frozen or switched off. Check it, and its battery driver.",
  silent: "An action server is on the graph but does not answer: it may be frozen. Look at its log.",
  duplicate: "More than one action server serves its docking action: shut down all but one.",
  gone: "No action server for its docking action: start its docking server.",
  battery: "It has a battery topic and no docking action.",
  unreachable:
    "Neither its docking server nor its battery is heard. Check that the robot is switched on and on the network.",
};

/** What a link means, and what to do about it. */
export function linkHint(link: Link): string {
  return link === "away" ? LINK_HINTS.away.replace("server", serverName()) : LINK_HINTS[link];
}

/** `now`, `12 s ago`, `3 min 05 s ago`; for ages that are looked at once a second. */
export function ageWords(ms: number): string {
  if (ms < 2000) return "now";
  return ms < 10_000 ? `${Math.floor(ms / 1000)} s ago` : `${formatDuration(ms)} ago`;
}
