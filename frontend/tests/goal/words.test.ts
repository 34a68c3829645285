import { describe, expect, it } from "vitest";
import { advice, currentGoal, meaning, outcome } from "../../src/goal/words";
import { at, goal, undockGoal } from "../events";

describe("a goal in words", () => {
  it("shows the newest that runs, else the one that ended last", () => {
    const ended = goal("new", { status: "rejected" });
    const running = goal("old");
    expect(currentGoal([ended, running])).toBe(running);
    expect(currentGoal([ended])).toBe(ended);
    const refused = goal("refused", { status: "rejected", finished_at: at(5) });
    const aborted = goal("aborted", { status: "aborted", finished_at: at(9) });
    expect(currentGoal([refused, aborted])).toBe(aborted);
    expect(currentGoal([])).toBeNull();
  });

  it("explains a stall, a loss and an error", () => {
    expect(meaning(goal("a", { stalled: true }))).toBe("Docking server not responding.");
    expect(advice(goal("a", { stalled: true }))).toMatch(/Stop/);
    expect(advice(goal("a", { status: "lost" }))).toMatch(/Check where the robot is/);
    const aborted = goal("a", { status: "aborted", error: { code: "battery_lost", detail: "no battery" } });
    expect(outcome(aborted)).toBe("Battery data stopped");
    expect(outcome(goal("a", { error: { code: "else", detail: "so it is" } }))).toBe("so it is");
    expect(advice(aborted)).toMatch(/battery driver/);
    expect(advice(goal("a", { error: { code: "else", detail: "" } }))).toBeNull();
  });

  it("says by what it was ended", () => {
    const blocked = { code: "blocked", detail: "no progress for 5.0 s" };
    expect(meaning(goal("a", { status: "aborted", error: blocked }))).toBe(
      "Docking failed: robot was blocked.",
    );
    expect(meaning(undockGoal("a", { status: "aborted" }))).toBe("Undocking failed.");
    const preempted = { code: "preempted", detail: "a newer goal came" };
    expect(meaning(goal("a", { status: "canceled", error: preempted }))).toBe(
      "Canceled: replaced by a newer goal.",
    );
    expect(meaning(goal("a", { status: "canceled" }))).toBe("Canceled on request.");
  });

  it("does not take a stop for a wish, nor for a failure", () => {
    const error = { code: "stopped", detail: "a stop was requested by Ada" };
    const stopped = goal("a", { status: "canceled", error });
    expect([meaning(stopped), outcome(stopped)]).toEqual(["Canceled by a stop.", "Canceled by a stop"]);
    expect(advice(stopped)).not.toMatch(/not sent/);
    const unsent = goal("a", { status: "rejected", error });
    expect(meaning(unsent)).toBe("Not sent: a stop came first.");
    expect(meaning(goal("a", { error }))).not.toMatch(/Canceled/);
  });

  it("means the same on every page, whatever its action", () => {
    expect(meaning(goal("a", { status: "succeeded" }))).toBe("The robot reached the dock.");
    expect(meaning(undockGoal("a", { status: "succeeded" }))).toBe("The robot left the dock.");
    expect(meaning(goal("a", { verb: null, status: "succeeded" }))).toBe("The goal succeeded.");
    const ours = { action_name: "/base/park", action_type: "our_msgs/action/Park" };
    expect(meaning(goal("a", { ...ours, status: "succeeded" }))).toBe("The robot reached the dock.");
  });
});
