import { describe, expect, it } from "vitest";
import { rate } from "../src/goal/facts";
import { describeVelocity } from "../src/scene/SceneCard";
import { formatDuration, formatTime } from "../src/ui/time";
import { at, cmdVel } from "./events";

describe("the feedback rate", () => {
  it("is messages a second over the last seconds", () => {
    const arrivals = Array.from({ length: 30 }, (_, index) => 7000 + index * 100);
    expect(rate(arrivals, 10_000)).toBeCloseTo(10);
    expect(rate(arrivals, 60_000)).toBeNull();
    expect(rate([1], 1)).toBeNull();
  });
});

describe("a velocity", () => {
  it("is said in words", () => {
    expect(describeVelocity(cmdVel(0, 0.15).cmd_vel)).toBe("turning left 0.15 rad/s");
    expect(describeVelocity(cmdVel(-0.1, -0.2).cmd_vel)).toBe("backward 0.1 m/s, turning right 0.2 rad/s");
    expect(describeVelocity(cmdVel(0, 0).cmd_vel)).toBe("standing still");
  });
});

describe("times", () => {
  it("are as short as they can be", () => {
    expect(formatDuration(400)).toBe("0.4 s");
    expect(formatDuration(12_900)).toBe("12 s");
    expect(formatDuration(185_000)).toBe("3 min 05 s");
    expect(formatDuration(7_620_000)).toBe("2 h 07 min");
    expect(formatDuration(100_000_000)).toBe("1 d 3 h");
    expect(formatDuration(-5)).toBe("0.0 s");
  });

  it("name the day only where it is another", () => {
    const time = Date.parse(at(0));
    expect(formatTime(time, time + 1000).length).toBeLessThan(formatTime(time, time + 9e8).length);
  });
});
