import type { Mission } from "./requests";

/** The priority of a mission that names none. */
export const PRIORITY = 50;

/** Whether no other state follows. */
export function hasEnded({ status }: Pick<Mission, "status">): boolean {
  return status === "succeeded" || status === "failed" || status === "canceled";
}

/** Whether it has begun and not ended: it has its robot. */
export function isActive(mission: Pick<Mission, "status" | "started_at">): boolean {
  return mission.started_at !== null && !hasEnded(mission);
}

/** The missions of a robot that have not ended. */
export interface Queue {
  robot: string;
  /** What it is on; null for none. */
  active: Mission | null;
  /** In the order in which they begin. */
  next: readonly Mission[];
}

/** The queues of the robots that have one, by the robots' names. */
export function queuesOf(missions: readonly Mission[]): Queue[] {
  const robots = [...new Set(missions.map(({ robot }) => robot))].sort((a, b) => a.localeCompare(b));
  return robots.map((robot) => {
    const own = missions.filter((mission) => mission.robot === robot && !hasEnded(mission));
    const active = own.find(isActive) ?? null;
    return { robot, active, next: own.filter((mission) => mission !== active).sort(byTurn) };
  });
}

/** The highest priority first, then the oldest. */
function byTurn(one: Mission, other: Mission): number {
  return other.priority - one.priority || Date.parse(one.created_at) - Date.parse(other.created_at);
}

/** The missions that have not ended, after one has changed. */
export function withMission(missions: readonly Mission[], changed: Mission): Mission[] {
  const others = missions.filter(({ mission_id }) => mission_id !== changed.mission_id);
  return hasEnded(changed) ? others : [...others, changed];
}
