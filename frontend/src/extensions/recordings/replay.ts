import type { Pose } from "@dock-gateway/client";
import { useEffect } from "react";
import type { Places, RecordedLayer } from "../../extension/extension";
import { type Point, place } from "../../store/geometry";
import type { LayerPainter, Scheme } from "../../store/layers";
import { lastUpTo } from "../../ui/crosshair";
import { fixed } from "../../ui/numbers";
import { SCENE_COLORS } from "../../ui/tokens";
import type { GoalReplay } from "./requests";
import { useReplay } from "./useReplay";

/** What was recorded longer before a moment says nothing of it (s). */
const OLD_S = 2;

/** What the recording of a goal adds to its replay; null while it is not known, and without a recording. */
export default function RecordedReplay({ goal, onLayer }: Places["replay"]): null {
  const { data } = useReplay(goal);
  useEffect(() => {
    if (data === undefined) return;
    onLayer({ scene: new RecordedScans(data), readings: (moment) => readingsAt(data, moment) });
    return () => onLayer(null);
  }, [data, onLayer]);
  return null;
}

/** What the laser saw at a moment of a goal, as its recording has it. */
export class RecordedScans implements RecordedLayer {
  #points: readonly Point[] = [];

  /** @param recorded What the replay shows of the recording. */
  constructor(private readonly recorded: GoalReplay) {}

  /** Goes to a moment of the goal (s); to its end for null. */
  seek(moment: number | null): void {
    const scan = at(this.recorded.scans, moment);
    this.#points = scan === null ? [] : scan.points.map(([x = 0, y = 0]) => ({ x, y }));
  }

  /** Drawn with the poses, which move at each moment, too. */
  subscribe(): () => void {
    return () => {};
  }

  groundIn(): null {
    return null;
  }

  paint(scheme: Scheme): LayerPainter {
    return {
      viewIn: (_, robot) => ({
        ground: null,
        lines: [],
        dots: [{ points: this.scanAt(robot), color: SCENE_COLORS[scheme].scan }],
      }),
      cornersIn: () => [],
      close: () => {},
    };
  }

  /** What the laser saw, in the frame that the pose of the robot is in. */
  scanAt(robot: Pose): readonly Point[] {
    return this.#points.map((point) => place(robot, point));
  }
}

/** What was last recorded at a moment (s); of the end for null, null where nothing is near. */
export function at<Each extends { offset_s: number }>(
  recorded: readonly Each[],
  moment: number | null,
): Each | null {
  const last = recorded.length - 1;
  const index =
    moment === null ? last : lastUpTo(moment, recorded.length, (each) => recorded[each]?.offset_s ?? 0);
  const found = recorded[index] ?? null;
  return found === null || (moment !== null && moment - found.offset_s > OLD_S) ? null : found;
}

/** The velocity that was commanded at a moment, and the state of the battery. */
export function readingsAt({ velocity, battery }: GoalReplay, moment: number | null): string[] {
  const told = at(velocity, moment);
  const said = at(battery, moment);
  const readings = [];
  if (told !== null && told.linear !== null && told.angular !== null)
    readings.push(`commanded ${fixed(told.linear, 2)} m/s, ${fixed(told.angular, 2)} rad/s`);
  if (said !== null && said.voltage !== null) readings.push(`battery ${fixed(said.voltage, 2)} V`);
  return readings;
}
