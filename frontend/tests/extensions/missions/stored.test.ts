import { describe, expect, it } from "vitest";
import { newStep } from "../../../src/extensions/missions/draft";
import { bodyOf as placeBody, errorsOf as placeErrors } from "../../../src/extensions/missions/places/places";
import {
  failureWords,
  missionWords,
  type NamedSchedule,
  bodyOf as scheduleBody,
  draftOf as scheduleDraft,
  errorsOf as scheduleErrors,
  whenWords,
  withEnabled,
} from "../../../src/extensions/missions/schedules/schedules";
import { usedIn } from "../../../src/extensions/missions/templates/parameters";
import {
  argumentsOf,
  bodyOf,
  draftOf,
  EXAMPLE,
  errorsOf,
  escaped,
  exampleDraft,
  missingIn,
  type NamedTemplate,
  parameterWords,
  placesIn,
  textOf,
  typedValue,
} from "../../../src/extensions/missions/templates/templates";
import { asFields, asJson, stepsFrom, stepsOf } from "../../../src/extensions/missions/written";
import { stepErrors } from "../../../src/extensions/missions/wrong";
import { poseWords } from "../../../src/scene/poseDraft";
import { placeIn } from "../../../src/scene/robotPose";

const NOW = Date.parse("2026-11-30T03:00:00Z");
const FETCH: NamedTemplate = {
  id: "fetch",
  etag: '"1"',
  name: "Fetch",
  priority: 50,
  battery: null,
  parameters: {
    shelf: { description: "Where to load", default: null },
    charge: { description: null, default: 0.8 },
  },
  steps: [{ navigate: { place: "$shelf" } }, { wait: { battery: "$charge" } }],
  changed_by: null,
  changed_at: "2026-11-30T02:00:00Z",
};
const NIGHT: NamedSchedule = {
  id: "night",
  etag: '"1"',
  name: "Night",
  enabled: true,
  robot: "/robot1",
  group: null,
  mission: {
    name: null,
    priority: 70,
    battery: null,
    steps: null,
    template: "fetch",
    arguments: { shelf: "a3" },
  },
  once: null,
  daily: { times: ["06:00", "22:00"], weekdays: ["mon", "fri"], time_zone: "Europe/Berlin" },
  every: null,
  if_running: "skip",
  last: null,
  next_at: "2026-12-04T05:00:00Z",
  changed_by: "Ada",
  changed_at: "2026-11-30T02:00:00Z",
};

describe("templates", () => {
  it("reads what is typed as JSON, or as text", () => {
    for (const value of ["a3", "3", 3, true, { x: 1 }, [1], "", " a", "null"])
      expect(typedValue(textOf(value))).toEqual(value);
    expect(typedValue(" ")).toBeUndefined();
    expect(textOf(null)).toBe("");
  });

  it("finds the parameters of steps, and those that are places", () => {
    const steps = [...FETCH.steps, { dock: { dock_id: "$$no", x: "$shelf" } }, { notify: { text: "$1" } }];
    expect(usedIn(steps)).toEqual(["shelf", "charge"]);
    expect([...placesIn(FETCH.steps)]).toEqual(["shelf"]);
    expect([...placesIn(steps)]).toEqual([]);
    expect(usedIn(escaped(steps))).toEqual([]);
    expect(parameterWords(FETCH)).toBe("Parameters: shelf, charge (0.8)");
    expect(parameterWords({ parameters: {} })).toBe("No parameters");
  });

  it("stores what was read, and only parameters that are used", () => {
    const { id, etag, changed_by, changed_at, ...fields } = FETCH;
    expect(bodyOf(draftOf(FETCH, NOW), "Ada")).toEqual({ ...fields, by: "Ada" });
    const draft = { ...draftOf(FETCH, NOW), steps: stepsFrom([{ dock: { dock_id: "$dock" } }], NOW) };
    expect(bodyOf(draft, null).parameters).toEqual({ dock: { description: null, default: null } });
    const limits = { below: 0.25, charge_to: 0.8 };
    const charging = draftOf({ ...FETCH, battery: limits }, NOW);
    expect(charging.battery).toEqual({ below: 25, chargeTo: 80 });
    expect(bodyOf(charging, null).battery).toEqual(limits);
    const low = errorsOf({ ...charging, battery: { below: 25, chargeTo: 20 } });
    expect(low.battery?.map(({ path }) => path)).toEqual(["battery.charge_to"]);
    expect(errorsOf({ ...draftOf(null, NOW), ...exampleDraft(EXAMPLE, NOW) })).toEqual({});
    expect(Object.keys(errorsOf({ ...draftOf(null, NOW), steps: [], priority: 101 }))).toEqual([
      "name",
      "priority",
      "steps",
    ]);
  });

  it("are steps with fields where those show all that is written, else JSON", () => {
    const kept: [string, unknown][] = [
      ["dock", { dock: {} }],
      ["dock", { dock: { dock_id: "$dock" }, tries: 3, name: "home" }],
      ["undock", { undock: {} }],
      ["navigate", { navigate: { place: "$shelf" }, interruptible: true }],
      ["navigate", { navigate: { pose: { x: 1, y: 2, yaw: 1.57, frame: "hall" } } }],
      ["wait", { wait: { battery: 0.8 }, timeout_s: 60, on_failure: { go_to: "home" } }],
      ["wait", { wait: { person: true } }],
      ["notify", { notify: { text: "$words", critical: true } }],
      ["call", { call: { service: "/reset", request: { data: "$on" } } }],
      ["publish", { publish: { topic: "/light", message: {}, type: "std_msgs/msg/Bool" } }],
      ["action", { action: { name: "/fibonacci", goal: { order: 5, tries: 1, other: null } } }],
      ["repeat", { repeat: { times: 3, steps: [{ wait: { seconds: "$s" } }] }, on_failure: "next" }],
      ["repeat", { repeat: { steps: [{ dock: {} }] } }],
      ["first_that_works", { first_that_works: [{ dock: {} }, { undock: {} }] }],
      ["json", { wait: { battery: "$charge" } }],
      ["json", { dock: {}, tries: "$tries" }],
      ["json", { dock: {}, timeout_s: "$limit" }],
      ["json", { action: { name: "/fibonacci", goal: { order: "$order" } } }],
      ["json", { repeat: { times: "$n", steps: [] } }],
      ["json", { dock: {}, undock: {} }],
      ["json", { fly: {} }],
      ["json", "$step"],
    ];
    for (const [kind, written] of kept) {
      const drafts = stepsFrom([written], NOW);
      expect([written, drafts.map((draft) => draft.kind)]).toEqual([written, [kind]]);
      const again = stepsOf(drafts);
      if (kind === "json") expect(again).toEqual([written]);
      // What is left out is as it is by default.
      expect(stepsFrom(again, NOW).map((draft) => draft.kind)).toEqual([kind]);
    }
    expect(stepsOf(stepsFrom([kept[1]?.[1]], NOW))).toEqual([kept[1]?.[1]]);
  });

  it("can be written as JSON, and have their fields again", () => {
    const step = newStep("wait", NOW, { seconds: 5 });
    const json = asJson(step);
    expect(json).toMatchObject({ key: step.key, kind: "json" });
    expect(json && asFields(json, NOW)).toMatchObject({ key: step.key, kind: "wait", seconds: 5 });
    const wrong = newStep("json", NOW, { content: "[" });
    expect(stepErrors(wrong, NOW)).toHaveLength(1);
    expect(asFields({ ...wrong, content: '"$step"' }, NOW)).toBeNull();
    expect(stepErrors({ ...wrong, content: '"$step"' }, NOW)).toEqual([]);
    expect(stepsOf([wrong])).toEqual([]);
  });

  it("asks for arguments that have no default", () => {
    expect(missingIn(FETCH, {})).toEqual(["shelf"]);
    expect(missingIn(FETCH, { shelf: "a3" })).toEqual([]);
    expect(argumentsOf(FETCH, { shelf: "a3", charge: "" })).toEqual({ shelf: "a3" });
    expect(argumentsOf(FETCH, { shelf: "a3", charge: "0.5", other: "1" })).toEqual({
      shelf: "a3",
      charge: 0.5,
    });
  });
});

describe("schedules", () => {
  it("stores what was read", () => {
    const { id, etag, last, next_at, changed_by, changed_at, ...fields } = NIGHT;
    const { steps, ...mission } = fields.mission;
    const { once: _once, every: _every, group: _group, ...times } = fields;
    const draft = scheduleDraft(NIGHT, "/", NOW);
    expect(scheduleErrors(draft, [FETCH])).toEqual({});
    expect(scheduleBody(draft, [FETCH], true, "Ada")).toEqual({ ...times, mission, by: "Ada" });
    expect(withEnabled(NIGHT, false, null)).toEqual({ ...fields, enabled: false, by: null });
    const grouped = scheduleBody({ ...draft, group: "pickers" }, [FETCH], true, null);
    expect(grouped).toMatchObject({ group: "pickers" });
    expect(grouped).not.toHaveProperty("robot");
    const hourly: NamedSchedule = { ...NIGHT, daily: null, every: { minutes: 90 }, if_running: "queue" };
    expect(scheduleBody(scheduleDraft(hourly, "/", NOW), [FETCH], true, null)).toMatchObject({
      every: { minutes: 90 },
      if_running: "queue",
    });
    const once: NamedSchedule = { ...NIGHT, daily: null, once: { due_at: "2026-12-01T06:00:00Z" } };
    expect(scheduleBody(scheduleDraft(once, "/", NOW), [FETCH], true, null).once).toEqual({
      due_at: "2026-12-01T06:00:00.000Z",
    });
  });

  it("says what is wrong", () => {
    const wrong = (change: object) =>
      Object.keys(scheduleErrors({ ...scheduleDraft(NIGHT, "/", NOW), ...change }, [FETCH]));
    expect(wrong({ name: " " })).toEqual(["name"]);
    expect(wrong({ template: "gone" })).toEqual(["template"]);
    expect(wrong({ typed: {} })).toEqual(["typed"]);
    expect(wrong({ template: "", steps: [] })).toEqual(["steps"]);
    expect(wrong({ times: ["24:00"], weekdays: [] })).toEqual(["times", "weekdays"]);
    expect(wrong({ when: "every", minutes: 0 })).toEqual(["minutes"]);
    expect(wrong({ when: "once", clock: "25" })).toEqual(["day"]);
  });

  it("says when, what and what came of it", () => {
    expect(whenWords(NIGHT)).toBe("Mon, Fri at 06:00, 22:00 (Europe/Berlin)");
    expect(whenWords({ once: null, daily: null, every: { minutes: 90 } })).toBe("Every 1 h 30 min");
    expect(missionWords(NIGHT, [FETCH])).toBe("Fetch (shelf: a3)");
    expect(missionWords(NIGHT, [])).toBe("fetch (shelf: a3)");
    const last = { due_at: "", decided_at: "", mission_id: null, code: "still_running", detail: "x" };
    expect(failureWords({ last })).toBe("Skipped: its last mission had not ended");
    expect(failureWords({ last: { ...last, code: "odd" } })).toBe("x");
    expect(failureWords({ last: { ...last, mission_id: "a", code: null, detail: null } })).toBeNull();
  });
});

describe("places", () => {
  it("are stored in radians and shown in degrees", () => {
    const draft = { name: "Shelf", x: 1.5, y: -2, heading: 90, frame: "map" };
    expect(placeErrors(draft)).toEqual({});
    const body = placeBody(draft, null);
    expect(body.yaw).toBeCloseTo(Math.PI / 2);
    expect(poseWords({ x: 1.5, y: -2, theta: Math.PI / 2, frame: "map" })).toBe("x 1.5 m, y -2 m, 90°");
    expect(Object.keys(placeErrors({ name: "", x: "", y: 2e6, heading: 400, frame: " " }))).toEqual([
      "name",
      "x",
      "y",
      "heading",
      "frame",
    ]);
  });

  it("are where a robot stands, in its map", () => {
    const scene = {
      frame: "odom" as const,
      robot: { x: 1, y: 0, theta: 0 },
      odom: null,
      dock: null,
      docked: null,
      staging: null,
      marker: null,
      infrared: null,
      footprint: null,
    };
    expect(placeIn(scene, null)).toBeNull();
    const odom = { x: 2, y: 3, theta: Math.PI / 2 };
    expect(placeIn(scene, { map: { frame: "hall" }, odom })).toEqual({
      x: 2,
      y: 4,
      heading: 90,
      frame: "hall",
    });
    const world = { ...scene, frame: "world" as const, odom: { x: 1, y: 0, theta: 0 } };
    expect(placeIn(world, null)).toEqual({ x: 1, y: 0, heading: 0, frame: "map" });
    expect(placeIn(world, { map: null, odom })).toEqual({ x: 2, y: 3, heading: 90, frame: "map" });
  });
});
