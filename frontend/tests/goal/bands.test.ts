import { describe, expect, it } from "vitest";
import { bandsOf, entryAt, timelineOf } from "../../src/goal/timeline";
import { at, goal, START, status } from "../events";

const events = [
  status("a", { status: "accepted" }, 1),
  status("a", { stage: "CONTROLLING", retries: 0 }, 2),
  status("a", { stage: "CONTROLLING", retries: 0, stalled: true }, 4),
  status("a", { stage: "RETRY", retries: 1 }, 6),
  status("a", { status: "canceling", stage: "RETRY", retries: 1 }, 7),
];

describe("the stages of a goal behind its plots", () => {
  it("last until the next one, whatever else changes meanwhile", () => {
    const running = goal("a", { status: "canceling", stage: "RETRY", retries: 1 });
    expect(bandsOf(timelineOf(running, events, true), START)).toEqual([
      { from: 2, to: 6, label: "Controlling", color: "blue" },
      { from: 4, to: 6, label: "Stalled", color: "orange" },
      { from: 6, to: null, label: "Backing off", color: "orange" },
    ]);
  });

  it("end with the goal", () => {
    const ended = goal("a", { status: "canceled", stage: "CANCELED", retries: 1, finished_at: at(9) });
    expect(bandsOf(timelineOf(ended, events, true), START).at(-1)).toMatchObject({ from: 6, to: 9 });
  });

  it("are not where it is unknown when they began", () => {
    const running = goal("a", { stage: "RETRY", retries: 1 });
    const late = timelineOf(running, events.slice(1, 4), false);
    expect(bandsOf(late, START).map(({ label }) => label)).toEqual(["Stalled", "Backing off"]);
  });
});

it("the entry of a moment is the last one that had begun", () => {
  const entries = timelineOf(goal("a", { status: "canceling", stage: "RETRY", retries: 1 }), events, true);
  const index = entryAt(entries, START + 3000);
  expect(entries[index]?.change).toMatchObject({ stage: "CONTROLLING" });
  expect(entryAt(entries, START)).toBe(-1);
});
