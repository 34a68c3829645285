// @vitest-environment jsdom
import { beforeEach, describe, expect, it, vi } from "vitest";
import { atBeat, BEAT_MS, onBeat } from "../src/clock/beat";
import { START } from "./events";

/** A frame of a screen that draws sixty of them a second, and the timer's millisecond. */
const FRAME_MS = 18;

describe("a beat", () => {
  beforeEach(() => {
    vi.useFakeTimers({ now: START + 30 });
  });

  it("comes at moments that its interval divides, whenever it was asked for", () => {
    const times: number[] = [];
    const stop = onBeat(200, () => times.push(Date.now() - START));
    vi.advanceTimersByTime(850);
    stop();
    expect(times).toHaveLength(4);
    for (const [index, time] of times.entries()) {
      expect(time).toBeGreaterThanOrEqual((index + 1) * 200);
      expect(time).toBeLessThan((index + 1) * 200 + FRAME_MS);
    }
  });

  it("comes on when the computer's clock is set back", () => {
    vi.spyOn(performance, "timeOrigin", "get").mockReturnValue(START + 30);
    const listener = vi.fn();
    const stop = onBeat(200, listener);
    vi.setSystemTime(START - 3_600_000);
    vi.advanceTimersByTime(850);
    stop();
    expect(listener).toHaveBeenCalledTimes(4);
  });

  it("is in one frame with those of other intervals", () => {
    const [often, seldom, once]: number[][] = [[], [], []];
    const stops = [
      onBeat(BEAT_MS, () => often?.push(performance.now())),
      onBeat(400, () => seldom?.push(performance.now())),
    ];
    atBeat(200, () => once?.push(performance.now()));
    vi.advanceTimersByTime(1000);
    for (const stop of stops) stop();
    expect(often).toHaveLength(15);
    expect(seldom).toHaveLength(2);
    expect(once).toHaveLength(1);
    expect(often).toEqual(expect.arrayContaining([...(seldom ?? []), ...(once ?? [])]));
  });

  it("comes no more to who has left, and still to the others", () => {
    const [left, stayed, once] = [vi.fn(), vi.fn(), vi.fn()];
    const leave = onBeat(200, left);
    onBeat(200, stayed);
    atBeat(200, once)();
    vi.advanceTimersByTime(300);
    leave();
    vi.advanceTimersByTime(1000);
    expect(left).toHaveBeenCalledTimes(1);
    expect(stayed.mock.calls.length).toBeGreaterThan(4);
    expect(once).not.toHaveBeenCalled();
  });
});
