import type { LiveGoal } from "@dock-gateway/client";
import { describe, expect, it } from "vitest";
import { spansOf, stageWords, stepsOf, timeIn } from "../../src/goal/stages";
import { reduce } from "../../src/store/reducer";
import { type Stages, withPast } from "../../src/store/stages";
import { initialState } from "../../src/store/state";
import { at, goal, START, snapshot, status, undockGoal } from "../events";

const PERCEPTION = "INITIAL_PERCEPTION";
const STAGING = "NAV_TO_STAGING_POSE";

const whole = (events: { time: string; stage: string | null }[]) => ({ events, complete: true });

function states(...parameters: Parameters<typeof stepsOf>): string[] {
  return stepsOf(...parameters).map((step) => step.state);
}

describe("the stages of a docking goal", () => {
  it("are shown as far as they are", () => {
    expect(states(goal("a"), [PERCEPTION])).toEqual(["current", "waiting", "waiting", "waiting"]);
    const approaching = [PERCEPTION, STAGING, "CONTROLLING"];
    expect(states(goal("a"), approaching)).toEqual(["done", "done", "current", "waiting"]);
  });

  it("are all done in the end, or end where it did not work", () => {
    const seen = [PERCEPTION, STAGING, "CONTROLLING", "WAIT_FOR_CHARGE"];
    expect(states(goal("a", { status: "succeeded" }), seen)).toEqual(Array(4).fill("done"));
    const aborted = goal("a", { status: "aborted" });
    expect(states(aborted, seen)).toEqual(["done", "done", "done", "failed"]);
  });

  it("are no failure where the goal was canceled", () => {
    const canceled = goal("a", { status: "canceled" });
    expect(states(canceled, [PERCEPTION, STAGING])).toEqual(["done", "canceled", "waiting", "waiting"]);
    expect(states(canceled, [PERCEPTION, "RETRY"])[0]).toBe("canceled");
  });

  it("are unknown, and no failure, where contact was lost", () => {
    const lost = goal("a", { status: "lost" });
    expect(states(lost, [PERCEPTION, STAGING])).toEqual(["done", "unknown", "waiting", "waiting"]);
    expect(states(lost, [PERCEPTION, "RETRY"])[0]).toBe("unknown");
  });

  it("show what did not work while the robot backs off, and then begin anew", () => {
    const seen = [PERCEPTION, STAGING, "CONTROLLING", "RETRY"];
    expect(states(goal("a"), seen)).toEqual(["done", "done", "failed", "waiting"]);
    expect(states(goal("a"), [...seen, STAGING])).toEqual(["done", "current", "waiting", "waiting"]);
  });

  it("go on while the robot presses again, and show what did not work while it goes back in the end", () => {
    const seen = [PERCEPTION, STAGING, "CONTROLLING", "WAIT_FOR_CHARGE", "CORRECTING"];
    expect(states(goal("a"), seen)).toEqual(["done", "done", "done", "current"]);
    expect(states(goal("a"), [...seen, "RETURN_TO_STAGING"])).toEqual(["done", "done", "done", "failed"]);
  });

  it("are one where the controller only controls, and none where nobody tells them", () => {
    expect(stepsOf(goal("a"), ["CONTROLLING"]).map((step) => step.label)).toEqual(["Controlling"]);
    expect(states(goal("a"), ["WAIT_FOR_BATTERY", "CONTROLLING"])).toEqual(["current"]);
    expect(stepsOf(goal("a"), [])).toEqual([]);
    expect(stepsOf(goal("a"), ["IDLE"])).toEqual([]);
  });
});

describe("the stages of an undocking goal", () => {
  it("are one", () => {
    expect(states(undockGoal("a"), ["UNDOCKING"])).toEqual(["current"]);
    expect(states(undockGoal("a", { status: "succeeded" }), ["UNDOCKING"])).toEqual(["done"]);
  });
});

describe("the stages of other docking servers", () => {
  const nav2 = goal("a", { action_type: "nav2_msgs/action/DockRobot" });
  const create3 = goal("a", { action_type: "irobot_create_msgs/action/Dock" });

  it("come in nav2's order, and come again with a retry", () => {
    expect(stepsOf(nav2, [STAGING]).map((step) => step.stage)).toEqual([
      STAGING,
      PERCEPTION,
      "CONTROLLING",
      "WAIT_FOR_CHARGE",
    ]);
    expect(states(nav2, [STAGING, PERCEPTION])).toEqual(["done", "current", "waiting", "waiting"]);
    const again = [STAGING, PERCEPTION, "CONTROLLING", PERCEPTION];
    expect(states(nav2, again)).toEqual(["done", "current", "waiting", "waiting"]);
    expect(states(nav2, ["CONTROLLING"])).toEqual(["done", "done", "current", "waiting"]);
  });

  it("are two of a Create 3", () => {
    expect(states(create3, [PERCEPTION])).toEqual(["current", "waiting"]);
    expect(states({ ...create3, status: "succeeded" }, [PERCEPTION, "CONTROLLING"])).toEqual([
      "done",
      "done",
    ]);
  });
});

describe("the way of a goal", () => {
  const visits = [
    { stage: PERCEPTION, since: START },
    { stage: "CONTROLLING", since: START + 2000 },
    { stage: "RETRY", since: START + 5000 },
    { stage: "CONTROLLING", since: START + 6000 },
  ];

  it("takes its time, stage by stage, up to now or to its end", () => {
    const times = (goalNow: LiveGoal) => spansOf(goalNow, visits, START + 10_000).map(({ ms }) => ms);
    expect(times(goal("a"))).toEqual([2000, 3000, 1000, 4000]);
    expect(times(goal("a", { status: "aborted", finished_at: at(7) }))).toEqual([2000, 3000, 1000, 1000]);
  });

  it("adds up its tries, and does not guess", () => {
    const spans = spansOf(goal("a"), visits, START + 10_000);
    expect(timeIn("CONTROLLING", spans)).toBe(7000);
    expect(timeIn("WAIT_FOR_CHARGE", spans)).toBeNull();
    const [, ...met] = visits;
    const unknown = spansOf(goal("a"), [{ stage: PERCEPTION, since: null }, ...met], START + 10_000);
    expect([timeIn(PERCEPTION, unknown), timeIn("CONTROLLING", unknown)]).toEqual([null, 7000]);
  });

  it("is completed out of the history, and keeps what came after that", () => {
    const met: Stages = new Map([
      [
        "a",
        [
          { stage: "CONTROLLING", since: null },
          { stage: "WAIT_FOR_CHARGE", since: START + 9000 },
        ],
      ],
    ]);
    const past = [
      { time: at(0), stage: null },
      { time: at(1), stage: PERCEPTION },
      { time: at(3), stage: "CONTROLLING" },
      { time: at(4), stage: "CONTROLLING" },
    ];
    expect(withPast(met, "a", whole(past)).get("a")).toEqual([
      { stage: PERCEPTION, since: START + 1000 },
      { stage: "CONTROLLING", since: START + 3000 },
      { stage: "WAIT_FOR_CHARGE", since: START + 9000 },
    ]);
    expect(withPast(met, "a", whole([]))).toBe(met);
  });

  it("has a gap where the history lags behind what was met, or reaches not back to the beginning", () => {
    const met: Stages = new Map([["a", [{ stage: "CONTROLLING", since: null }]]]);
    const lagging = [{ time: at(1), stage: PERCEPTION }];
    expect(withPast(met, "a", whole(lagging)).get("a")).toEqual([
      { stage: PERCEPTION, since: START + 1000 },
      { stage: "CONTROLLING", since: null },
    ]);
    const late = { events: [{ time: at(50), stage: "CONTROLLING" }], complete: false };
    expect(withPast(met, "a", late).get("a")).toEqual([{ stage: "CONTROLLING", since: null }]);
  });

  it("has a gap where the page was away, until the history tells", () => {
    const begun = [snapshot(), status("a", { stage: "CONTROLLING" }, 1)];
    const later = goal("a", { stage: "CONTROLLING", retries: 1 });
    const state = [...begun, snapshot({ goals: [later] })].reduce(
      (now, event) => reduce(now, event, 0),
      initialState,
    );
    expect(state.stages.get("a")).toEqual([{ stage: "CONTROLLING", since: null }]);
  });
});

describe("a stage in words", () => {
  it("is a sentence, where it is a stage of the way", () => {
    expect(stageWords("RETRY")).toMatch(/try again/);
    expect(stageWords("SUCCEEDED")).toBeNull();
    expect(stageWords(null)).toBeNull();
  });
});
