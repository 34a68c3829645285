import { describe, expect, it } from "vitest";
import { goalName, lastWords, runningWords } from "../../src/goal/words";
import { goal, undockGoal } from "../events";

const fibonacci = { action_name: "/robot1/fibonacci", verb: null };

describe("a robot's goal", () => {
  it("is called by what it does, whatever the name and the type of its action", () => {
    const park = { action_name: "/base/park", action_type: "our_msgs/action/Park" };
    expect(goalName(goal("a", park))).toBe("Dock");
    expect(goalName(undockGoal("a"))).toBe("Undock");
    expect(goalName(goal("a", fibonacci))).toBe("fibonacci");
  });

  it("is told by its stage while it runs, and by what came of it", () => {
    expect(runningWords(goal("a", { stage: "CONTROLLING" }))).toBe("Dock: Controlling");
    expect(runningWords(goal("a", fibonacci))).toBe("fibonacci: executing");
    expect(lastWords(undockGoal("a", { status: "succeeded" }))).toBe("Off the dock");
    expect(lastWords(undockGoal("a", { status: "canceled" }))).toBe("Undock canceled");
    expect(lastWords(goal("a", { ...fibonacci, status: "succeeded" }))).toBe("fibonacci succeeded");
  });
});
