import { screen, within } from "@testing-library/react";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
// Loaded on demand by the page: on a busy machine their first import takes longer than a test waits.
import "../../../src/extensions/missions/day/DayPage";
import { axisOf, dayAround, movedMiddle, ticksOf } from "../../../src/extensions/missions/day/axis";
import { type Bar, lanesOf, partsOf, placeOf, rowsOf } from "../../../src/extensions/missions/day/bars";
import { barWords, plannedWords, stateWords } from "../../../src/extensions/missions/day/dayWords";
import { plansOf } from "../../../src/extensions/missions/day/planned";
import type { Mission, MissionStep } from "../../../src/extensions/missions/requests";
import type { NamedSchedule } from "../../../src/extensions/missions/schedules/schedules";
import { Naming } from "../../../src/fleet/names";
import { setZone } from "../../../src/ui/zone";
import { robot } from "../../events";
import { fakeGateway, renderPage } from "../../page";
import { CHARGE, DOCK, FAILED, HELD, NESTED, NIGHT, NOW, QUEUED } from "./examples";

const MINUTE = 60_000;
const HOUR = 60 * MINUTE;
const at = (time: string) => Date.parse(time);

beforeEach(() => setZone("utc"));
afterEach(() => setZone("local"));

const EVERY: NamedSchedule = {
  id: "sweep",
  etag: '"1"',
  name: "Sweep",
  enabled: true,
  robot: "/robot1",
  group: null,
  mission: { name: null, priority: null, battery: null, steps: [], template: null, arguments: null },
  once: null,
  daily: null,
  every: { minutes: 360 },
  if_running: "skip",
  last: null,
  next_at: "2026-11-30T04:00:00Z",
  changed_by: null,
  changed_at: "2026-11-30T02:00:00Z",
};
const daily = (times: string[], time_zone: string, next_at: string, weekdays = ["mon", "tue", "sun"]) =>
  ({ ...EVERY, every: null, daily: { times, time_zone, weekdays }, next_at }) as NamedSchedule;

describe("what schedules will queue", () => {
  const timesOf = (schedule: NamedSchedule, from: number, to: number) =>
    plansOf([schedule], from, to).map((plan) => new Date(plan.at).toISOString().slice(0, 16));

  it("is every so many minutes from the next time on", () => {
    const day = dayAround(NOW);
    expect(timesOf(EVERY, NOW, day.to)).toEqual([
      "2026-11-30T04:00",
      "2026-11-30T10:00",
      "2026-11-30T16:00",
      "2026-11-30T22:00",
    ]);
    expect(timesOf(EVERY, at("2026-11-30T10:00:01Z"), day.to)).toHaveLength(2);
    expect(timesOf({ ...EVERY, next_at: "2026-12-02T00:00:00Z" }, NOW, day.to)).toEqual([]);
    expect(timesOf({ ...EVERY, enabled: false }, NOW, day.to)).toEqual([]);
    expect(timesOf({ ...EVERY, next_at: null }, NOW, day.to)).toEqual([]);
  });

  it("is once at its time", () => {
    const once = { ...EVERY, every: null, once: { due_at: "2026-11-30T04:00:00Z" } };
    expect(timesOf(once, NOW, dayAround(NOW).to)).toEqual(["2026-11-30T04:00"]);
  });

  it("is at times of day in their zone, on their days", () => {
    const berlin = daily(["00:30", "06:00", "22:00"], "Europe/Berlin", "2026-11-30T05:00:00Z");
    const day = dayAround(NOW);
    // 00:30 on Tuesday in Berlin is still Monday in UTC.
    const expected = ["2026-11-30T05:00", "2026-11-30T21:00", "2026-11-30T23:30"];
    expect(timesOf(berlin, NOW, day.to)).toEqual(expected);
    const monday = { ...berlin, daily: { ...berlin.daily, weekdays: ["mon"] } } as NamedSchedule;
    expect(timesOf(monday, NOW, day.to)).toEqual(expected.slice(0, 2));
    expect(timesOf(daily(["06:00"], "Mars/Olympus", "2026-11-30T05:00:00Z"), NOW, day.to)).toEqual([
      "2026-11-30T05:00",
    ]);
  });

  it("knows the two odd nights of a year", () => {
    const spring = daily(["02:30", "03:30"], "Europe/Berlin", "2026-03-29T01:00:00Z");
    expect(timesOf(spring, at("2026-03-29T00:00:00Z"), at("2026-03-29T12:00:00Z"))).toEqual([
      "2026-03-29T01:00", // 02:30 does not occur: 03:00
      "2026-03-29T01:30",
    ]);
    const autumn = daily(["02:30"], "Europe/Berlin", "2026-10-25T00:30:00Z");
    expect(timesOf(autumn, at("2026-10-25T00:00:00Z"), at("2026-10-25T12:00:00Z"))).toEqual([
      "2026-10-25T00:30", // the first of the two
    ]);
  });
});

describe("the axis", () => {
  const day = { from: at("2026-11-30T00:00:00Z"), to: at("2026-12-01T00:00:00Z") };

  it("is the day, or a part of it that does not leave it", () => {
    expect(dayAround(NOW)).toEqual(day);
    expect(axisOf("day", day, NOW)).toEqual(day);
    expect(axisOf("6h", day, NOW)).toEqual({ from: day.from, to: day.from + 6 * HOUR });
    expect(axisOf("1h", day, NOW + MINUTE)).toEqual({ from: NOW - HOUR / 2, to: NOW + HOUR / 2 });
    expect(axisOf("1h", day, day.to)).toEqual({ from: day.to - HOUR, to: day.to });
    const later = axisOf("6h", day, movedMiddle(axisOf("6h", day, NOW), 1));
    expect(later.from).toBe(day.from + 3 * HOUR);
  });

  it("has round times with room between them", () => {
    expect(ticksOf(day, day, 13)).toHaveLength(13);
    expect(ticksOf(axisOf("1h", day, NOW), day, 8).map((tick) => (tick - day.from) / MINUTE)).toEqual([
      150, 160, 170, 180, 190, 200, 210,
    ]);
    expect(ticksOf(day, day, 1)).toHaveLength(5);
  });

  it("places what is seen of a period", () => {
    const axis = { from: 0, to: 100 };
    expect(placeOf({ from: 25, to: 50 }, axis)).toEqual({ left: 25, width: 25 });
    expect(placeOf({ from: -50, to: 10 }, axis)).toEqual({ left: 0, width: 10 });
    expect(placeOf({ from: 90, to: 400 }, axis)).toEqual({ left: 90, width: 10 });
  });
});

describe("the rows", () => {
  const ran: Mission = { ...FAILED, mission_id: "r", schedule: "sweep", status: "succeeded", error: null };

  it("are one for each group whose missions no robot has begun", () => {
    const any = { ...QUEUED, mission_id: "g", robot: null, group: "pickers" };
    const plans = plansOf([{ ...EVERY, robot: null, group: "cleaners" }], NOW, dayAround(NOW).to);
    const rows = rowsOf(["/robot1"], [any], plans, NOW, new Naming([]));
    expect(rows.map(({ robot, group, next }) => robot ?? `${group} ${next}`)).toEqual([
      "/robot1",
      "cleaners 0",
      "pickers 1",
    ]);
    expect(rows[1]?.bars.map(({ kind }) => kind)).toEqual(["planned", "planned", "planned", "planned"]);
  });

  it("are one for each robot, with missions from their start to their end or to now, and what is planned", () => {
    const plans = plansOf([EVERY], NOW, dayAround(NOW).to);
    const [one, two, ...others] = rowsOf(
      ["/robot2", "/robot1"],
      [NIGHT, QUEUED, ran],
      plans,
      NOW,
      new Naming([]),
    );
    expect([one?.robot, two?.robot, others.length]).toEqual(["/robot1", "/robot2", 0]);
    expect(one?.next).toBe(1);
    expect(two?.bars).toEqual([]);
    const began = at("2026-11-30T02:00:01Z");
    expect(one?.bars.slice(0, 2).map(({ from, to }) => [from, to])).toEqual([
      [began, NOW],
      [began, at("2026-11-30T02:10:01Z")],
    ]);
    // As long as the last one took.
    expect(one?.bars.slice(2).map(({ from, to }) => to - from)).toEqual(Array(4).fill(10 * MINUTE));
  });

  it("have one bar for a schedule that is due very often", () => {
    const often = { ...EVERY, every: { minutes: 5 } };
    const [row] = rowsOf([], [], plansOf([often], NOW, dayAround(NOW).to), NOW, new Naming([]));
    expect(row?.bars).toMatchObject([{ kind: "planned", times: 240 }]);
    const [bar] = row?.bars ?? [];
    expect(bar?.kind === "planned" && plannedWords(bar)).toBe("Planned 240 times, 04:00 – 23:55");
  });

  it("have the steps that have begun", () => {
    const ended = (step: MissionStep): MissionStep => ({
      ...step,
      started_at: "2026-11-30T02:00:02Z",
      finished_at: "2026-11-30T02:05:02Z",
    });
    const [dock, ...rest] = NIGHT.steps;
    const parts = partsOf({ ...NIGHT, steps: [ended(dock ?? DOCK), ...rest] }, NOW);
    expect(parts.map(({ from, to }) => to - from)).toEqual([5 * MINUTE]);
    expect(partsOf(NIGHT, NOW)[0]?.to).toBe(NOW);
    expect(partsOf({ ...NIGHT, steps: NESTED.map(ended) }, NOW)).toHaveLength(4); // not those with others inside
  });
});

describe("the lanes", () => {
  const axis = { from: 0, to: 1000 };
  const over: Mission = { ...FAILED, status: "succeeded", error: null };
  const bar = (from: number, to: number): Bar => ({ kind: "mission", mission: over, from, to });
  const shape = (bars: Bar[], most = 2) =>
    lanesOf(bars, axis, 30, most).map((lane) =>
      lane.map((each) => (each.kind === "bundle" ? each.bars.length : each.from)),
    );

  it("are as few as bars have room in", () => {
    expect(shape([bar(0, 100), bar(100, 200), bar(200, 200)])).toEqual([[0, 100, 200]]);
    expect(shape([bar(0, 5), bar(10, 200)])).toEqual([[0], [10]]);
    expect(shape([bar(-50, -10), bar(-50, 10), bar(1000, 1010)])).toEqual([[-50]]); // others are not seen
  });

  it("do not overlap where bars are moved into sight", () => {
    expect(shape([bar(960, 960), bar(995, 995)])).toEqual([[960], [995]]);
    expect(shape([bar(-500, 0), bar(10, 40)])).toEqual([[-500], [10]]);
  });

  it("bundle what has no room", () => {
    const bars = [0, 1, 2, 3, 4, 50].map((from) => bar(from, from));
    const lanes = lanesOf(bars, axis, 30, 2);
    expect(lanes.flat().flatMap((each) => (each.kind === "bundle" ? each.bars : [each]))).toHaveLength(6);
    expect(lanes.length).toBe(2);
    for (const lane of lanes)
      for (const [index, each] of lane.slice(1).entries())
        expect(each.from).toBeGreaterThanOrEqual((lane[index]?.from ?? 0) + 30);
  });
});

describe("the mission that a robot is on", () => {
  it("is never bundled", () => {
    const ended = (from: number): Bar => ({ kind: "mission", mission: { ...FAILED }, from, to: from });
    const now: Bar = { kind: "mission", mission: NIGHT, from: 4, to: 10 };
    const lanes = lanesOf([ended(0), ended(1), ended(2), ended(3), now], { from: 0, to: 1000 }, 30, 3);
    expect(lanes).toHaveLength(3);
    expect(lanes[2]).toEqual([now]);
  });
});

describe("the words", () => {
  it("say how a mission stands and what its steps are", () => {
    expect(stateWords(NIGHT)).toBe("Running. Step 1 of 3: Dock");
    expect(stateWords(HELD)).toBe("The robot was stopped. Step 1 of 3: Dock");
    expect(stateWords(FAILED)).toBe("Failed: Took longer than its timeout");
    const words = barWords({ kind: "mission", mission: NIGHT, from: NOW - HOUR, to: NOW });
    expect(words).toContain("Night, 02:00 – now. Running.");
    expect(words).toContain("Dock: Now");
    const many = { ...NIGHT, steps: Array(10).fill(CHARGE) };
    expect(barWords({ kind: "mission", mission: many, from: NOW, to: NOW })).toContain("and 2 more steps");
  });
});

describe("the page", () => {
  const open = (missions: Mission[], schedules: NamedSchedule[] = []) => {
    const asked: string[] = [];
    vi.stubGlobal("fetch", async (request: Request) => {
      const { pathname, searchParams } = new URL(request.url);
      if (pathname === "/schedules") return Response.json({ schedules });
      if (pathname !== "/missions") return Response.json({}, { status: 404 });
      asked.push(searchParams.get("since") ?? "");
      const wanted = searchParams.getAll("status");
      return Response.json({
        missions: missions.filter(({ status }) => wanted.includes(status)),
        next_cursor: null,
      });
    });
    renderPage(fakeGateway(), { robots: [robot("/robot1"), robot("/robot2")] }, "/ui/missions/today");
    return asked;
  };
  const minutesAgo = (minutes: number) => new Date(Date.now() - minutes * MINUTE).toISOString();

  it("has a row for each robot, and bars that lead to missions and schedules", async () => {
    const next_at = new Date(dayAround(Date.now()).to - 1000).toISOString();
    const once = { ...EVERY, every: null, once: { due_at: next_at }, next_at };
    const asked = open([{ ...NIGHT, started_at: minutesAgo(1) }, QUEUED], [once]);
    const row = await screen.findByRole("listitem", { name: "/robot1" });
    const bar = within(row).getByRole("link", { name: /^Night, .*now\. Running\. Step 1 of 3: Dock/ });
    expect(bar.getAttribute("href")).toBe("/ui/missions/a");
    expect(within(row).getByRole("link", { name: "1 next" })).toBeDefined();
    const planned = await within(row).findByRole("link", { name: /^Sweep\. Planned, 23:59/ });
    expect(planned.getAttribute("href")).toBe("/ui/missions/schedules");
    const other = screen.getByRole("list", { name: "Missions of /robot2" });
    expect(within(other).queryAllByRole("listitem")).toEqual([]);
    expect(asked).toContain(new Date(dayAround(Date.now()).from).toISOString());
  });

  it("teaches where there is nothing", async () => {
    open([]);
    await screen.findByText("No missions today");
    expect(screen.getByRole("button", { name: "New mission" })).toBeDefined();
  });
});
