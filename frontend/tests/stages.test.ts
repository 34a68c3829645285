import { describe, expect, it } from "vitest";
import { stageWords, stepsOf } from "../src/docking/stages";
import { goal, undockGoal } from "./events";

const PERCEPTION = "INITIAL_PERCEPTION";
const STAGING = "NAV_TO_STAGING_POSE";

function states(...parameters: Parameters<typeof stepsOf>): string[] {
  return stepsOf(...parameters).map((step) => step.state);
}

describe("the stages of a docking goal", () => {
  it("are shown as far as they are", () => {
    expect(states(goal("a"), [PERCEPTION], "dock")).toEqual(["current", "waiting", "waiting", "waiting"]);
    const approaching = [PERCEPTION, STAGING, "CONTROLLING"];
    expect(states(goal("a"), approaching, "dock")).toEqual(["done", "done", "current", "waiting"]);
  });

  it("are all done in the end, or end where it did not work", () => {
    const seen = [PERCEPTION, STAGING, "CONTROLLING", "WAIT_FOR_CHARGE"];
    expect(states(goal("a", { status: "succeeded" }), seen, "dock")).toEqual(Array(4).fill("done"));
    const aborted = goal("a", { status: "aborted" });
    expect(states(aborted, seen, "dock")).toEqual(["done", "done", "done", "failed"]);
  });

  it("show what did not work while the robot backs off, and then begin anew", () => {
    const seen = [PERCEPTION, STAGING, "CONTROLLING", "RETRY"];
    expect(states(goal("a"), seen, "dock")).toEqual(["done", "done", "failed", "waiting"]);
    expect(states(goal("a"), [...seen, STAGING], "dock")).toEqual(["done", "current", "waiting", "waiting"]);
  });

  it("are one where the controller only controls, and none where nobody tells them", () => {
    expect(stepsOf(goal("a"), ["CONTROLLING"], "dock").map((step) => step.label)).toEqual(["Controlling"]);
    expect(states(goal("a"), ["WAIT_FOR_BATTERY", "CONTROLLING"], "dock")).toEqual(["current"]);
    expect(stepsOf(goal("a"), [], "dock")).toEqual([]);
    expect(stepsOf(goal("a"), ["IDLE"], "dock")).toEqual([]);
  });
});

describe("the stages of an undocking goal", () => {
  it("are one", () => {
    expect(states(undockGoal("a"), ["UNDOCKING"], "undock")).toEqual(["current"]);
    expect(states(undockGoal("a", { status: "succeeded" }), ["UNDOCKING"], "undock")).toEqual(["done"]);
  });
});

describe("a stage in words", () => {
  it("is a sentence, where it is a stage of the way", () => {
    expect(stageWords("RETRY")).toMatch(/try again/);
    expect(stageWords("SUCCEEDED")).toBeNull();
    expect(stageWords(null)).toBeNull();
  });
});
