import { openAlerts, urgentFirst } from "../../alerts/order";
import type { Alert, Robot } from "../../api/types";
import { byName } from "../../fleet/names";
import { isThere, isUnreachable, LINK_WORDS, linkOf } from "../../fleet/words";
import type { Frames } from "./fleetScenes";

/** What sets a robot apart from those that are as they should be. */
export interface Mark {
  level: "critical" | "warning";
  words: string;
}

export interface Placed {
  robot: Robot;
  mark: Mark | null;
}

export interface Missing {
  robot: Robot;
  why: string;
}

/** Which robots are on the map, and why the others are not; by name. Odometry has a frame for each robot alone. */
export function placement(
  robots: Iterable<Robot>,
  frames: Frames,
  alerts: readonly Alert[],
): { placed: Placed[]; missing: Missing[] } {
  const placed: Placed[] = [];
  const missing: Missing[] = [];
  for (const robot of [...robots].sort((a, b) => byName(a.name, b.name))) {
    const frame = frames.get(robot.name);
    if (frame === "world") placed.push({ robot, mark: markOf(robot, alerts) });
    else if (isThere(robot)) missing.push({ robot, why: reasonOf(robot, frame) });
  }
  return { placed, missing };
}

function reasonOf(robot: Robot, frame: "odom" | undefined): string {
  if (frame === "odom") return "Only odometry, in a frame of its own";
  if (isUnreachable(robot)) return LINK_WORDS[linkOf(robot)];
  return robot.simulated ? "No pose from its simulator" : "No simulator, no odometry yet";
}

function markOf(robot: Robot, alerts: readonly Alert[]): Mark | null {
  if (robot.stop.latched) return { level: "critical", words: "Stopped" };
  const [alert] = urgentFirst(openAlerts(alerts.filter((each) => each.robot === robot.name)));
  if (alert !== undefined) return { level: alert.severity, words: alert.title };
  return isUnreachable(robot) ? { level: "warning", words: LINK_WORDS[linkOf(robot)] } : null;
}
