import { describe, expect, it } from "vitest";
import { between, edges, formatSpan, LIVE, pan, pause, zoom } from "../src/battery/view";

const NOW = 100_000;

describe("the part of time that the plots show", () => {
  it("is the last five minutes, and moves on with time", () => {
    expect(edges(LIVE, NOW)).toEqual({ from: NOW - 300, to: NOW });
    expect(edges(LIVE, NOW + 60).to).toBe(NOW + 60);
  });

  it("stands still while it is paused", () => {
    const paused = pause(LIVE, NOW);
    expect(edges(paused, NOW + 60)).toEqual({ from: NOW - 300, to: NOW });
    expect(pause(paused, NOW + 60)).toEqual(paused);
  });

  it("gets larger towards the past, and goes on to follow now", () => {
    expect(zoom(LIVE, 0.5, 0.5, NOW)).toEqual({ spanS: 600, endS: null });
    expect(zoom(LIVE, 2, 1, NOW)).toEqual({ spanS: 150, endS: null });
  });

  it("gets smaller around the crosshair, whose moment stays where it is", () => {
    const view = zoom(LIVE, 2, 0.5, NOW);
    expect(view).toEqual({ spanS: 150, endS: NOW - 75 });
    const farther = zoom({ spanS: 100, endS: NOW - 1000 }, 0.5, 0.25, NOW);
    const { from } = edges(farther, NOW);
    expect(from + 0.25 * farther.spanS).toBe(NOW - 1000 - 75);
  });

  it("never reaches beyond now, and follows it where it was moved there", () => {
    const earlier = pan(LIVE, -0.5, NOW);
    expect(earlier).toEqual({ spanS: 300, endS: NOW - 150 });
    expect(pan(earlier, 0.25, NOW).endS).toBe(NOW - 75);
    expect(pan(earlier, 1, NOW)).toEqual(LIVE);
    expect(zoom(earlier, 0.1, 0.5, NOW).endS).toBeNull();
  });

  it("is what was dragged across, whichever way, and not less than can be seen", () => {
    expect(between(NOW - 50, NOW - 100, NOW)).toEqual({ spanS: 50, endS: NOW - 50 });
    expect(between(NOW - 50, NOW - 50, NOW).spanS).toBe(2);
    expect(zoom(LIVE, 1e-9, 1, NOW).spanS).toBe(31 * 86_400);
  });

  it("is named in a few words", () => {
    expect([300, 3600, 86_400, 604_800, 30, 5400].map(formatSpan)).toEqual([
      "5 min",
      "1 h",
      "24 h",
      "7 d",
      "30 s",
      "90 min",
    ]);
  });
});
