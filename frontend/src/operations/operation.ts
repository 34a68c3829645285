import type { GoalSummary, Robot, Verb } from "@dock-gateway/client";
import { ofSites } from "../api/places";
import { whyNotSend } from "../docking/families";
import { whyNotCancel } from "../goal/words";

/** What can be done to robots, one or several, from any page. */
export const OPERATIONS = ["dock", "undock", "cancel", "stop"] as const;
export type Operation = (typeof OPERATIONS)[number];

/** What can be done from this page: on those about several sites robots can be stopped, and the rest is done at their sites. */
export function operationsHere(): readonly Operation[] {
  return ofSites() ? ["stop"] : OPERATIONS;
}

export const OPERATION_NAMES: Record<Operation, string> = {
  dock: "Dock",
  undock: "Undock",
  cancel: "Cancel",
  stop: "Stop",
};

/** Robots that are asked at the same time. A browser has six connections to the gateway: two are left for a Stop. */
const AT_ONCE = 4;

/** The operation that moves a robot; null where none does. */
export function moveOf(operation: Operation): Verb | null {
  return operation === "dock" || operation === "undock" ? operation : null;
}

/**
 * Why this cannot be done to a robot now, in a sentence; null where it can. Stop always can.
 *
 * @param sending A goal was sent to it and is not answered.
 */
export function whyNot(
  operation: Operation,
  robot: Robot,
  live: boolean,
  sending: boolean = false,
): string | null {
  if (operation === "stop") return null;
  if (operation === "cancel") {
    const goal = cancelable(robot)[0] ?? robot.goals[0] ?? null;
    return whyNotCancel(live, goal, false);
  }
  const names = [robot.dock?.action_name, robot.undock?.action_name];
  const running = robot.goals.find(({ action_name }) => names.includes(action_name)) ?? null;
  const stopped = robot.stop.latched;
  return whyNotSend(operation, { live, stopped, running, sending, server: robot[operation] });
}

/** The goals of a robot that a cancel is for. */
export function cancelable({ goals }: Robot): GoalSummary[] {
  return goals.filter(({ status }) => status !== "pending" && status !== "canceling");
}

export interface Refusal {
  name: string;
  reason: string;
}

/** The robots that it can be done to, and why it cannot be done to the others. */
export function divide(
  operation: Operation,
  robots: readonly Robot[],
  live: boolean,
): { able: Robot[]; unable: Refusal[] } {
  const able: Robot[] = [];
  const unable: Refusal[] = [];
  for (const robot of robots) {
    const reason = whyNot(operation, robot, live);
    if (reason === null) able.push(robot);
    else unable.push({ name: robot.name, reason });
  }
  return { able, unable };
}

/** Calls `act` for each, a few at a time, in their order. */
export async function fewAtOnce<Item>(
  items: readonly Item[],
  act: (item: Item) => Promise<void>,
): Promise<void> {
  const waiting = [...items];
  const work = async () => {
    for (let item = waiting.shift(); item !== undefined; item = waiting.shift()) await act(item);
  };
  await Promise.all(Array.from({ length: AT_ONCE }, work));
}
