import type { Verb } from "@dock-gateway/client";
import { describe, expect, it } from "vitest";
import { Naming } from "../../src/fleet/names";
import { goalName, goalTitle, lastWords, runningWords } from "../../src/goal/words";
import { goal, undockGoal } from "../events";

const fibonacci = { action_name: "/robot1/fibonacci", verb: null };

describe("a robot's goal", () => {
  it("is called by what it does, whatever the name and the type of its action", () => {
    const park = { action_name: "/base/park", action_type: "our_msgs/action/Park" };
    expect(goalName(goal("a", park))).toBe("Dock");
    expect(goalName(undockGoal("a"))).toBe("Undock");
    expect(goalName(goal("a", fibonacci))).toBe("Fibonacci");
    const asked = { ...goal("a"), goal: { dock_id: "charger_2" } };
    expect(goalName(asked)).toBe("Dock at charger_2");
    expect(goalName({ ...asked, goal: { dock_id: "" } })).toBe("Dock");
    expect(goalName({ ...asked, goal: { dock_id: "old", use_dock_id: false } })).toBe("Dock");
  });

  it("is named with its robot where there are others", () => {
    const naming = new Naming([
      { name: "/robot1", display_name: "Left forklift", groups: [] },
      { name: "/", display_name: null, groups: [] },
    ]);
    const title = (action_name: string, verb: Verb | null = null) => goalTitle({ action_name, verb }, naming);
    expect(title("/robot1/connect_to_charging_dock", "dock")).toBe("Dock, Left forklift");
    expect(title("/robot1/arm/pick_up")).toBe("Pick up, Left forklift");
    expect(title("/dock_robot", "dock")).toBe("Dock, Robot");
    expect(title("/robot7/undock_robot", "undock")).toBe("Undock, /robot7");
    expect(goalTitle({ action_name: "/dock_robot", verb: "dock" }, new Naming([]))).toBe("Dock");
  });

  it("is told by its stage while it runs, and by what came of it", () => {
    expect(runningWords(goal("a", { stage: "CONTROLLING" }))).toBe("Dock: Controlling");
    expect(runningWords(goal("a", fibonacci))).toBe("Fibonacci: executing");
    expect(lastWords(undockGoal("a", { status: "succeeded" }))).toBe("Left the dock");
    expect(lastWords(undockGoal("a", { status: "canceled" }))).toBe("Undock canceled");
    expect(lastWords(goal("a", { ...fibonacci, status: "succeeded" }))).toBe("Fibonacci succeeded");
  });
});
