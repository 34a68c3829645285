import { describe, expect, it } from "vitest";
import { RecordedScans, readingsAt } from "../../../src/extensions/recordings/replay";
import type { GoalReplay } from "../../../src/extensions/recordings/requests";

const RECORDED: GoalReplay = {
  scans: [
    { offset_s: 0, points: [[1, 0]] },
    { offset_s: 2, points: [[2, 0]] },
  ],
  velocity: [{ offset_s: 1, linear: 0.25, angular: -0.5 }],
  battery: [{ offset_s: 1, voltage: 8.756, percentage: null }],
  log: [],
};

describe("the recording of a goal in its replay", () => {
  it("has the scan of a moment as seen from the robot", () => {
    const seen = new RecordedScans(RECORDED);
    const points = (moment: number | null) => {
      seen.seek(moment);
      return seen.scanAt({ x: 10, y: 0, theta: Math.PI / 2 }).map(({ y }) => y);
    };
    expect(points(1)).toEqual([1]);
    expect(points(3)).toEqual([2]);
    expect(points(null)).toEqual([2]);
    expect(points(60)).toEqual([]);
  });

  it("says what the robot was told and what its battery said, as far as that is recorded", () => {
    expect(readingsAt(RECORDED, 1.5)).toEqual(["commanded 0.25 m/s, −0.50 rad/s", "battery 8.76 V"]);
    expect(readingsAt(RECORDED, 0.5)).toEqual([]);
  });
});
