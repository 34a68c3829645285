import { useFleet } from "../../fleet/context";
import { useAnswer } from "../../ui/requests";
import { dockingTimes } from "./requests";
import type { View } from "./view";

/** The statistics are read again after this time: they change slowly. */
const FRESH_MS = 5 * 60_000;

/** How long docking has taken the robots that are chosen, by week. */
export function useDockingTimes({ robot, group }: Pick<View, "robot" | "group">) {
  const { http } = useFleet();
  return useAnswer({
    queryKey: ["docking time", robot, group],
    queryFn: ({ signal }) =>
      dockingTimes(
        http,
        { ...(robot === null ? {} : { robot }), ...(group === null ? {} : { group }) },
        signal,
      ),
    staleTime: FRESH_MS,
  });
}
