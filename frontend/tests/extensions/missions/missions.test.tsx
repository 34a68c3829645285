import { screen, waitFor, within } from "@testing-library/react";
import { describe, expect, it } from "vitest";
import { shapeOf } from "../../../src/actions/form/shapes";
import { session } from "../../../src/api/session";
// Loaded on demand by the page: on a busy machine their first import takes longer than a test waits.
import "../../../src/extensions/missions/MissionPage";
import "../../../src/extensions/missions/MissionsPage";
import "../../../src/extensions/missions/NewMissionPage";
import "../../../src/extensions/missions/openMissions";
import { withField } from "../../../src/actions/form/draft";
import {
  exampleMission,
  newMission,
  newStep,
  type StepKind,
  withMoved,
} from "../../../src/extensions/missions/draft";
import { draftOf } from "../../../src/extensions/missions/fromMission";
import { groupQueuesOf, queuesOf, withMission } from "../../../src/extensions/missions/queue";
import type { Mission, MissionStep } from "../../../src/extensions/missions/requests";
import { bodyOf } from "../../../src/extensions/missions/toRequest";
import {
  breakWords,
  depthOf,
  errorWords,
  holdOf,
  limitWords,
  missionName,
  nowWords,
  numberOf,
  optionWords,
  stepPlace,
  stepWords,
} from "../../../src/extensions/missions/words";
import {
  errorAt,
  goalOf,
  isReady,
  missionErrors,
  stepErrors,
  withGoal,
  withRefused,
} from "../../../src/extensions/missions/wrong";
import { robot } from "../../events";
import { fakeGateway, renderPage } from "../../page";
import { tell } from "../../streams";
import {
  ANY,
  answering,
  BLOCK,
  BREAK,
  CALL,
  CHARGE,
  CHARGING,
  COUNT,
  DOCK,
  DRIVE,
  FAILED,
  HELD,
  LIMITS,
  NESTED,
  NIGHT,
  NOTIFY,
  NOW,
  PLACE,
  PUBLISH,
  QUEUED,
  SHELF,
  WAIT,
} from "./examples";

const ROBOTS = { robots: [robot("/robot1"), robot("/robot2")] };
const open = (path = "/ui/missions") => renderPage(fakeGateway(), ROBOTS, path);
const spaces = (text: string) => text.replaceAll("\u00a0", " ");

describe("the words", () => {
  it("name steps and missions", () => {
    expect([DOCK, COUNT].map(stepWords)).toEqual(["Dock", "Fibonacci"]);
    expect(stepWords({ ...DOCK, dock: { dock_id: "lab" } })).toBe("Dock at lab");
    expect(spaces(stepWords(CHARGE))).toBe("Wait until the battery has 80 %");
    expect(stepWords({ ...CHARGE, wait: { ...WAIT, seconds: 90 } })).toBe("Wait 1 min 30 s");
    expect(stepWords({ ...CHARGE, wait: { ...WAIT, person: true } })).toBe("Wait until someone continues");
    expect([DRIVE, CALL, PUBLISH, NOTIFY].map(stepWords)).toEqual([
      "Drive to x 1.5 m, y -2 m",
      "Call /reset",
      "Publish on /light",
      "Tell people: Load me",
    ]);
    expect(NESTED.slice(0, 2).map(stepWords)).toEqual([
      "Repeat for ever, round 7",
      "The first of 2 that works",
    ]);
    expect(stepWords({ ...BLOCK, repeat: { times: 3, round: 0 } })).toBe("Repeat 3 times");
    expect(stepWords({ ...BLOCK, repeat: { times: 1, round: 1 } })).toBe("Once");
    expect(NESTED.map(numberOf)).toEqual(["1", "1.1", "1.1.1", "1.1.2", "1.2", "2"]);
    expect(stepPlace({ steps: NESTED, step: 3 })).toBe("Step 1.1.2");
    expect(stepPlace({ steps: NIGHT.steps, step: 1 })).toBe("Step 2 of 3");
    expect(NESTED.map(depthOf)).toEqual([0, 1, 2, 2, 1, 0]);
    expect(missionName({ name: null, steps: NESTED })).toBe("Repeat for ever, round 7, Dock");
    const through: MissionStep = { ...DRIVE, navigate: { place: null, pose: null, poses: [PLACE, PLACE] } };
    expect(stepWords(through)).toBe("Drive through 2 places");
    expect(stepWords({ ...DRIVE, navigate: SHELF })).toBe("Drive to shelf");
    const hall: MissionStep = {
      ...DRIVE,
      navigate: { place: null, pose: { ...PLACE, frame: "hall" }, poses: null },
    };
    expect(stepWords(hall)).toBe("Drive to x 1.5 m, y -2 m in hall");
    expect(missionName(NIGHT)).toBe("Night");
    expect(missionName({ name: null, steps: [DOCK, COUNT, DOCK, DOCK] })).toBe("Dock, Fibonacci, Dock, …");
  });

  it("say what a robot does during a break for its battery", () => {
    const words = (change: Partial<Mission>, charge: number | null = 0.43) =>
      spaces(nowWords({ ...CHARGING, ...change }, charge, NOW));
    expect(words({})).toBe("Battery at 43 %; the mission goes on at 80 %");
    expect(words({ battery: null }, null)).toBe("The battery's charge is unknown");
    const docking = { ...BREAK, stage: "docking", tried: 1 } as const;
    expect(words({ recharge: docking, waits_for: "retry" })).toBe("Try 2 begins within half a minute");
    expect(words({ recharge: docking, waits_for: "goal" })).toBe("The goal is running");
    expect(spaces(limitWords(LIMITS))).toBe("Returns below 25 %, charges to 80 %");
    expect([CHARGING, NIGHT].map(breakWords)).toEqual(["Charging", null]);
    expect(optionWords({ ...DRIVE, interruptible: true })).toBe("left to charge");
    expect(holdOf({ held_for: "approval", started_at: null })?.title).toBe("An agent asks for it");
  });

  it("say what a mission waits for", () => {
    expect(nowWords(NIGHT, null, NOW)).toBe("The goal is running");
    const charging: Mission = { ...NIGHT, step: 1, waits_for: "battery" };
    expect(spaces(nowWords(charging, 0.43, NOW))).toBe("Battery at 43 %; goes on at 80 %");
    expect(spaces(nowWords(charging, null, NOW))).toContain("unknown; goes on at 80 %");
    const started_at = new Date(NOW - 18_000).toISOString();
    const waiting = { ...CHARGE, wait: { ...WAIT, seconds: 30 }, started_at };
    expect(nowWords({ ...NIGHT, waits_for: "time", steps: [waiting] }, null, NOW)).toBe("Goes on in 12 s");
    expect(nowWords({ ...NIGHT, waits_for: null }, null, NOW)).toBe("");
    expect(nowWords({ ...NIGHT, status: "canceling" }, null, NOW)).toContain("being canceled");
    expect(holdOf(HELD)?.words).toContain("does not go on by itself");
    expect(holdOf({ held_for: "paused", started_at: null })?.words).toContain("does not begin");
    expect(errorWords({ code: "step_timeout", detail: "" })).toBe("Took longer than its timeout");
    expect(errorWords({ code: "obstructed", detail: "" })).toBe("Obstacle in the way");
  });
});

describe("the queue", () => {
  it("has the active mission first, then by priority and place", () => {
    const later = { ...QUEUED, mission_id: "d", order: 2, created_at: "2026-11-30T01:30:00Z" };
    const same = { ...QUEUED, mission_id: "g", order: 2 };
    const urgent = { ...later, mission_id: "e", priority: 70 };
    const other = { ...QUEUED, mission_id: "f", robot: "/robot2" };
    const [one, two] = queuesOf([same, later, other, QUEUED, NIGHT, urgent, FAILED]);
    expect(one?.active).toBe(NIGHT);
    expect(one?.next.map(({ mission_id }) => mission_id)).toEqual(["e", "b", "d", "g"]);
    expect(two).toMatchObject({ robot: "/robot2", active: null, next: [other] });
  });

  it("is one of each group for what no robot has begun", () => {
    const second = { ...ANY, mission_id: "h", order: 3 };
    const sweep = { ...ANY, mission_id: "i", group: "sweepers" };
    expect(queuesOf([ANY, second, sweep])).toEqual([]);
    expect(groupQueuesOf([sweep, second, NIGHT, ANY])).toEqual([
      { group: "pickers", next: [ANY, second] },
      { group: "sweepers", next: [sweep] },
    ]);
  });

  it("loses those that end", () => {
    expect(withMission([NIGHT, QUEUED], HELD)).toEqual([QUEUED, HELD]);
    expect(withMission([NIGHT], { ...NIGHT, status: "succeeded" })).toEqual([]);
  });
});

describe("a draft", () => {
  const shape = shapeOf({
    properties: { order: { type: "integer", minimum: 0, maximum: 46, default: 0 } },
  });

  it("is the request that it was read from", () => {
    const steps = [{ ...DOCK, dock: { dock_id: "lab" }, tries: 3 }, CHARGE, COUNT];
    const draft = draftOf({ ...NIGHT, steps }, NOW);
    expect(isReady(draft, NOW)).toBe(true);
    expect(JSON.parse(bodyOf(draft, "Bob"))).toEqual({
      name: "Night",
      priority: 50,
      by: "Bob",
      steps: [
        { dock: { dock_id: "lab" }, tries: 3, on_failure: "end" },
        { wait: { battery: 0.8 }, tries: 1, on_failure: "end" },
        { action: { name: "/fibonacci", goal: { order: 5 } }, tries: 1, on_failure: "end" },
      ],
    });
  });

  it("keeps places, calls, messages and notices", () => {
    const through: MissionStep = { ...DRIVE, navigate: { place: null, pose: null, poses: [PLACE] } };
    const draft = draftOf(
      { ...NIGHT, steps: [DRIVE, through, CALL, PUBLISH, NOTIFY, { ...DRIVE, navigate: SHELF }] },
      NOW,
    );
    expect(isReady(draft, NOW)).toBe(true);
    const { steps } = JSON.parse(bodyOf(draft, null));
    expect(steps[0].navigate.pose).toEqual({ ...PLACE, yaw: expect.closeTo(Math.PI / 2, 6) });
    expect(steps[1].navigate).toEqual({ poses: [PLACE] });
    expect(steps[2].call).toEqual(CALL.call);
    expect(steps[3].publish).toEqual(PUBLISH.publish);
    expect(steps[4].notify).toEqual(NOTIFY.notify);
    expect(steps[5].navigate).toEqual({ place: "shelf" });
  });

  it("keeps steps that are inside of others", () => {
    const draft = draftOf({ ...NIGHT, steps: NESTED }, NOW);
    expect(isReady(draft, NOW)).toBe(true);
    expect(draft.steps.map(({ kind }) => kind)).toEqual(["repeat", "dock"]);
    const alternatives = [{ dock: { dock_id: "a" }, tries: 3 }, { dock: {} }];
    expect(JSON.parse(bodyOf(draft, null)).steps).toEqual([
      {
        repeat: {
          times: null,
          steps: [
            { first_that_works: alternatives, on_failure: "next" },
            { wait: { ...WAIT, battery: 0.8 } },
          ],
        },
        on_failure: { go_to: "home" },
      },
      { dock: {}, name: "home", tries: 1, on_failure: "end" },
    ]);
    const first = draftOf(
      {
        ...NIGHT,
        steps: NESTED.slice(1, 4).map((step) => ({
          ...step,
          path: step.path.replace("0.repeat.steps.", ""),
        })),
      },
      NOW,
    );
    expect(JSON.parse(bodyOf(first, null)).steps).toEqual([
      { first_that_works: alternatives, on_failure: "next" },
    ]);
    const wrong = (kind: StepKind, change: object = {}) =>
      stepErrors(newStep(kind, NOW, change), NOW).map(({ path }) => path);
    expect(wrong("repeat")).toEqual([]);
    expect(wrong("repeat", { times: 0.5, content: "[]" })).toEqual(["repeat.times", "repeat.steps"]);
    expect(wrong("first_that_works", { content: "{}" })).toEqual(["first_that_works"]);
  });

  it("says what is wrong with places, calls, messages and notices", () => {
    const wrong = (kind: StepKind, change: object = {}) =>
      stepErrors(newStep(kind, NOW, change), NOW).map(({ path }) => path);
    expect(wrong("navigate")).toEqual(["navigate.pose.x", "navigate.pose.y"]);
    const place = { x: 1, y: 2e6, heading: 400, frame: " " };
    expect(wrong("navigate", { place })).toEqual(
      ["y", "yaw", "frame"].map((name) => `navigate.pose.${name}`),
    );
    expect(wrong("call")).toEqual(["call.service"]);
    expect(wrong("call", { target: "reset", content: "[1]" })).toEqual(["call.service", "call.request"]);
    expect(wrong("publish", { target: "/light", content: "{" })).toEqual(["publish.message"]);
    expect(wrong("notify", { text: " " })).toEqual(["notify.text"]);
  });

  it("has the battery in percent", () => {
    const drive = { ...DRIVE, interruptible: true };
    const draft = draftOf({ ...NIGHT, battery: { below: 0.255, charge_to: 0.9 }, steps: [drive] }, NOW);
    expect(draft.battery).toEqual({ below: 25.5, chargeTo: 90 });
    expect(JSON.parse(bodyOf(draft, null))).toMatchObject({
      battery: { below: 0.255, charge_to: 0.9 },
      steps: [{ interruptible: true }],
    });
    const wrong = (below: number | string, chargeTo: number | string) =>
      missionErrors({ ...draft, battery: { below, chargeTo } }).map(({ path, detail }) => [path, detail]);
    expect(wrong(25, 30)).toEqual([]);
    expect(wrong(25, 29)).toEqual([["battery.charge_to", "From 30 to 100 %"]]);
    expect(wrong(96, 100)).toEqual([["battery.below", "From 1 to 95 %"]]);
    expect(wrong("", 80)).toEqual([["battery.below", "From 1 to 95 %"]]);
    expect(wrong(25, "")).toEqual([["battery.charge_to", "From 30 to 100 %"]]);
  });

  it("says what is wrong with it", () => {
    expect(missionErrors({ ...newMission("/"), priority: 101 }).map(({ path }) => path)).toEqual([
      "priority",
      "steps",
    ]);
    const wrong = (change: object, kind: "wait" | "action" = "wait") =>
      stepErrors(newStep(kind, NOW, change), NOW).map(({ path }) => path);
    expect(wrong({})).toEqual([]);
    expect(wrong({ seconds: "" })).toEqual(["wait.seconds"]);
    expect(wrong({ wait: "battery", charge: 101 })).toEqual(["wait.battery"]);
    expect(wrong({ wait: "until", day: "2026-11-29", clock: "06:00" })).toEqual(["wait.until"]);
    expect(wrong({ wait: "until", clock: "25:00" })).toEqual(["wait.until"]);
    expect(wrong({ wait: "person", timeout: 0.5, tries: 21 })).toEqual(["timeout_s", "tries"]);
    expect(wrong({}, "action")).toEqual(["action.name"]);
    const step = newStep("action", NOW, { action: "/fibonacci" });
    const filled = withGoal(step, shape, withField(goalOf(step, shape), ["order"], "47"));
    expect(stepErrors(filled, NOW).map(({ path }) => path)).toEqual(["action.goal.order"]);
  });

  it("has what was refused at its step, wherever that is moved, until it is changed", () => {
    const draft = { ...exampleMission("/", NOW), name: "Charge" };
    const steps = [...draft.steps, newStep("action", NOW, { action: "/fibonacci" })];
    const refused = withRefused({ ...draft, steps }, [
      { path: "steps.1.wait.battery", detail: "too high" },
      { path: "steps.3.action.goal.order", detail: "too large" },
      { path: "name", detail: "taken" },
    ]);
    expect(refused.refused).toEqual([{ path: "name", detail: "taken" }]);
    const moved = withMoved(refused.steps, 1, -1);
    expect(errorAt(moved[0]?.refused ?? [], "wait.battery")).toBe("too high");
    const last = refused.steps[3] ?? newStep("dock", NOW);
    expect(goalOf(last, shape).refused).toEqual([{ path: "order", detail: "too large" }]);
    expect(withGoal(last, shape, withField(goalOf(last, shape), ["order"], "3")).refused).toEqual([]);
    expect(withMoved(moved, 0, -1)).toBe(moved);
  });
});

describe("the page", () => {
  it("shows what runs, what comes next and what has ended, and follows events", async () => {
    const asked = answering([NIGHT, QUEUED, FAILED]);
    const { user } = open();
    const section = await screen.findByRole("region", { name: "/robot1" });
    expect(within(section).getByText("Step 1 of 3: Dock")).toBeDefined();
    expect(within(section).getByRole("link", { name: "Goal 3f0c" }).getAttribute("href")).toBe(
      "/ui/goals/3f0c",
    );
    expect(within(screen.getByRole("list", { name: "Next for /robot1" })).getByText("Dock")).toBeDefined();
    expect(screen.getByText("Not on a mission: /robot2")).toBeDefined();
    expect(await screen.findByText("Took longer than its timeout")).toBeDefined();
    const event = { type: "mission", time: NIGHT.created_at, mission: HELD } as const;
    tell(event);
    await user.click(await screen.findByRole("button", { name: "Continue: Night" }));
    await waitFor(() => expect(asked.map(({ path }) => path)).toEqual(["/missions/a/continue"]));
  });

  it("shows what waits for a robot of a group, and lets one begin that was stopped", async () => {
    const asked = answering([
      ANY,
      { ...ANY, mission_id: "h", name: "After a stop", order: 3, waits_for: "continue" },
    ]);
    const { user } = open();
    const section = await screen.findByRole("region", { name: "Any of pickers" });
    expect(within(section).getByText(/Waiting for a robot of the group/)).toBeDefined();
    expect(within(section).queryByRole("button", { name: "Continue: Dock" })).toBeNull();
    await user.click(within(section).getByRole("button", { name: "Continue: After a stop" }));
    await waitFor(() => expect(asked.map(({ path }) => path)).toEqual(["/missions/h/continue"]));
  });

  it("shows a break for the battery, and lets one be asked for by pressing", async () => {
    const failed = { code: "no_dock", detail: "the dock was not seen" };
    const docking: Mission = {
      ...CHARGING,
      waits_for: "retry",
      recharge: { ...BREAK, stage: "docking", tried: 1, goal_id: "5e1d", error: failed },
    };
    const asked = answering([docking]);
    const { user } = open();
    const card = await screen.findByRole("article", { name: "Night" });
    expect(within(card).getByText("Returning to its dock")).toBeDefined();
    expect(within(card).getByText(/the dock was not seen/i)).toBeDefined();
    expect(within(card).getByRole("link", { name: "Goal 5e1d" })).toBeDefined();
    expect(within(card).getByText("Then Step 1 of 3: Dock")).toBeDefined();
    await user.click(screen.getByRole("button", { name: "New mission" }));
    await user.click(await screen.findByRole("button", { name: "Add step: Dock" }));
    await user.click(screen.getByRole("checkbox", { name: /Return to charge/ }));
    const chargeTo = screen.getByRole("textbox", { name: "Charges to" });
    await user.clear(chargeTo);
    await user.type(chargeTo, "20");
    expect(screen.getByText("From 30 to 100 %")).toBeDefined();
    await user.clear(chargeTo);
    await user.type(chargeTo, "60");
    await user.click(screen.getByRole("button", { name: "Start mission" }));
    await waitFor(() => expect(asked).toHaveLength(1));
    expect(JSON.parse(asked[0]?.body ?? "").battery).toEqual({ below: 0.25, charge_to: 0.6 });
  });

  it("teaches where there is nothing, and starts an example by pressing", async () => {
    const asked = answering([]);
    const { user } = open();
    await user.click(await screen.findByRole("button", { name: /Example/ }));
    await user.click(await screen.findByRole("button", { name: "Move step 3 up" }));
    const steps = within(screen.getByRole("list", { name: "Steps" })).getAllByRole("listitem");
    expect(steps.map((step) => step.getAttribute("aria-label"))).toEqual([
      "Step 1: Dock",
      "Step 2: Undock",
      "Step 3: Wait",
    ]);
    await user.click(screen.getByRole("button", { name: "Start mission" }));
    await screen.findByRole("heading", { name: "Missions" });
    expect(asked[0]?.path).toBe("/missions?robot=%2Frobot1");
    expect(Object.keys(JSON.parse(asked[0]?.body ?? "").steps[1])[0]).toBe("undock");
  });

  it("shows what was refused at its field, and says what is missing", async () => {
    answering([FAILED], { path: "steps.1.wait.battery", detail: "no battery here" });
    const { user } = open("/ui/missions/new?from=c");
    await user.click(await screen.findByRole("button", { name: "Start mission" }));
    const field = await screen.findByRole("textbox", { name: "Until the battery has" });
    await waitFor(() => expect(field.getAttribute("aria-invalid")).toBe("true"));
    expect(screen.getByText("no battery here")).toBeDefined();
    await user.click(screen.getByRole("button", { name: "Add step: Action" }));
    expect(screen.queryByText("Choose an action.")).toBeDefined();
  });

  it("puts a call and a notice together", async () => {
    const asked = answering([]);
    const { user } = open("/ui/missions/new");
    await user.click(await screen.findByRole("button", { name: "Add step: Call" }));
    expect(screen.queryByRole("button", { name: "Add step: Drive" })).toBeNull(); // no nav2 here
    await user.type(screen.getByRole("textbox", { name: "Service" }), "/reset");
    await user.click(screen.getByRole("button", { name: "Add step: Tell people" }));
    await user.type(screen.getByRole("textbox", { name: "Text" }), "Load me");
    await user.click(screen.getByRole("checkbox", { name: /Critical/ }));
    await user.click(screen.getByRole("button", { name: "Add step: Repeat" }));
    expect(screen.getByRole("textbox", { name: "Steps" })).toBeDefined();
    await user.click(screen.getByRole("button", { name: "Start mission" }));
    await waitFor(() => expect(asked).toHaveLength(1));
    const [call, notify, repeat] = JSON.parse(asked[0]?.body ?? "").steps;
    expect(call.call).toEqual({ service: "/reset", type: null, request: {} });
    expect(repeat.repeat).toEqual({ times: 2, steps: [{ wait: { seconds: 60 } }] });
    expect(notify.notify).toEqual({ text: "Load me", critical: true });
  });

  it("shows a viewer no buttons", async () => {
    answering([HELD, QUEUED, FAILED]);
    session.set({
      ...session.state,
      principal: { name: "Vera", kind: "user", role: "viewer", robots: [], actions: [], topics: [] },
    });
    open();
    await screen.findByText(/does not go on by itself/);
    await screen.findByRole("link", { name: "Round" });
    const buttons = within(screen.getByRole("main")).queryAllByRole("button");
    expect(buttons).toEqual([]);
  });
});
