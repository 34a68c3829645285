import type { Robot } from "@dock-gateway/client";
import { useServices } from "../store/context";
import { useFleetPart } from "./context";
import { defaultRobot } from "./names";

/** What is read off the robot of this page, as all pages have it; re-renders only where that is another. */
export function useRobotPart<Part>(read: (robot: Robot | undefined) => Part): Part {
  const { robot } = useServices();
  return useFleetPart("robots", (robots) => read(robots.get(robot ?? defaultRobot(robots))));
}

/** Whether the robot of this page is docked; null where that is unknown. */
export function useDocked(): boolean | null {
  return useRobotPart((robot) => robot?.docked ?? null);
}
