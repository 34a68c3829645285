import { lazyPart } from "../../ui/lazyPart";
import { useDockingTimes } from "./dockingTimes";

const DockingTimeCard = lazyPart(() => import("./DockingTrend"));

/** How long docking takes this robot; nothing where it has not docked in two weeks. */
export function RobotDockingTime({ robot }: { robot: string }) {
  const { data } = useDockingTimes({ robot, group: null });
  const trend = data?.find((each) => each.robot === robot);
  return trend !== undefined && <DockingTimeCard trend={trend} />;
}
