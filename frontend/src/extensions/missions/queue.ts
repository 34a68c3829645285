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

/** Whether it is neither edited nor moved any more. */
export function hasBegun(mission: Pick<Mission, "status" | "started_at">): boolean {
  return mission.started_at !== null || hasEnded(mission);
}

/** The missions of a robot that have not ended. */
export interface Queue {
  robot: string;
  /** What it is on; null for none. */
  active: Mission | null;
  /** In the order in which they begin. */
  next: readonly Mission[];
}

/** The missions for a group that no robot has begun. */
export interface GroupQueue {
  group: string;
  /** In the order in which they begin. */
  next: readonly Mission[];
}

/** The queues of the robots that have one, by the robots' names. */
export function queuesOf(missions: readonly Mission[]): Queue[] {
  return namesOf(missions, ({ robot }) => robot).map((robot) => {
    const own = missions.filter((mission) => mission.robot === robot && !hasEnded(mission));
    const active = own.find(isActive) ?? null;
    return { robot, active, next: own.filter((mission) => mission !== active).sort(byTurn) };
  });
}

/** The queues of the groups that have one, by the groups' names. */
export function groupQueuesOf(missions: readonly Mission[]): GroupQueue[] {
  const unbegun = missions.filter((mission) => mission.robot === null && !hasEnded(mission));
  return namesOf(unbegun, ({ group }) => group).map((group) => ({
    group,
    next: unbegun.filter((mission) => mission.group === group).sort(byTurn),
  }));
}

function namesOf(missions: readonly Mission[], read: (mission: Mission) => string | null): string[] {
  return [...new Set(missions.flatMap((mission) => read(mission) ?? []))].sort((a, b) => a.localeCompare(b));
}

/** The highest priority first, then the lowest place in the order, as the gateway has it. */
export function byTurn(one: Mission, other: Mission): number {
  return (
    other.priority - one.priority ||
    one.order - other.order ||
    Date.parse(one.created_at) - Date.parse(other.created_at) ||
    (one.mission_id < other.mission_id ? -1 : 1)
  );
}

/** The missions that have not ended, after one has changed. */
export function withMission(missions: readonly Mission[], changed: Mission): Mission[] {
  const others = missions.filter(({ mission_id }) => mission_id !== changed.mission_id);
  return hasEnded(changed) ? others : [...others, changed];
}
