import type { Robot, StopState } from "@dock-gateway/client";
import { defaultRobot, inOrder, isUnder } from "../fleet/names";
import { isThere } from "../fleet/words";

/** A stop that holds, with what it holds besides; released for all of them together. */
export interface HeldStop {
  robot: string;
  since: string | null;
  by: string | null;
  /** All robots that it holds, itself first, then by name; without a configured one that does not exist. */
  holds: string[];
  /** False where a restart of the gateway would lose it. */
  persisted: boolean;
}

/**
 * The stops that hold, the outermost of each: a stop of `/` holds every robot, and is released for all of them.
 *
 * @param stop That of the robot that the gateway is configured for, which is known first.
 */
export function heldStops(stop: StopState, robots: ReadonlyMap<string, Robot>): HeldStop[] {
  const name = defaultRobot(robots);
  const latched = new Map<string, StopState>();
  for (const robot of robots.values()) if (robot.stop.latched) latched.set(robot.name, robot.stop);
  latched.delete(name);
  if (stop.latched) latched.set(name, stop);
  const label = (name: string) => robots.get(name) ?? { name, display_name: null };
  const compare = (a: string, b: string) => inOrder(label(a), label(b));
  const names = [...latched.keys()].sort(compare);
  return [...latched]
    .filter(([held]) => !names.some((other) => other !== held && isUnder(held, other)))
    .map(([held, { stopped_at: since, by, robots: under, persisted }]) => {
      const below = [...new Set([...names, ...under])]
        .filter((other) => other !== held && isUnder(other, held))
        .sort(compare);
      const robot = robots.get(held);
      const exists = below.length === 0 || robot === undefined || isThere(robot);
      const holds = exists ? [held, ...below] : below;
      return { robot: held, since, by, persisted, holds };
    })
    .sort((a, b) => compare(a.robot, b.robot));
}

/** Whether there are several robots, and stops hold every one of them. */
export function holdsAll(held: readonly HeldStop[], robots: ReadonlyMap<string, Robot>): boolean {
  const names = new Set(held.flatMap(({ holds }) => holds));
  const there = [...robots.values()].filter(isThere);
  return there.length > 1 && there.every(({ name }) => names.has(name));
}

/** Stops that are so close together (ms) are one: those of many robots go in several requests. */
const ONE_STOP_MS = 2000;

/** Whether two times are so close together that stops at them are one. */
export function areOneStop(one: string | null, other: string | null): boolean {
  return Math.abs(Date.parse(one ?? "") - Date.parse(other ?? "")) < ONE_STOP_MS;
}

/** Whether robots were stopped together, by the same person, and all of it is stored. */
export function isOneStop(held: readonly HeldStop[]): boolean {
  const [first] = held;
  return held.every(
    ({ by, since, persisted }) => persisted && by === first?.by && areOneStop(since, first?.since ?? null),
  );
}
