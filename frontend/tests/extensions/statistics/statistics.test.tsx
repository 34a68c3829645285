import { screen, waitFor, within } from "@testing-library/react";
import { describe, expect, it, vi } from "vitest";
import { goalsLink, percent } from "../../../src/extensions/statistics/cells";
import { durationMarks, errorMarks, rateMarks, roundTicks } from "../../../src/extensions/statistics/plots";
import type {
  DockingTrend,
  GoalCounts,
  GoalGroup,
  Statistics,
} from "../../../src/extensions/statistics/requests";
import { sparkline, trendWords } from "../../../src/extensions/statistics/trend";
import { statisticsView, toQuery } from "../../../src/extensions/statistics/view";
import { dayOf } from "../../../src/ui/time";
import { zoneName } from "../../../src/ui/zone";
import { robot } from "../../events";
import { fakeGateway, renderPage } from "../../page";

const read = (text: string) => statisticsView.read(new URLSearchParams(text));

function counts(change: Partial<GoalCounts> = {}): GoalCounts {
  return {
    ended: 20,
    statuses: { succeeded: 16, canceled: 2, aborted: 1, rejected: 0, lost: 1 },
    success_rate: 16 / 18,
    duration_s: { p10: 27.5, median: 31.204, p90: 1044.87 },
    mean_retries: 0.25,
    errors: [
      { code: "blocked", count: 1 },
      { code: "gripper_jammed", count: 1 },
    ],
    other_errors: 3,
    goals_path: "/goals?since=2026-11-20T00:00:00Z&until=2026-11-22T00:00:00Z",
    ...change,
  };
}

const none = counts({
  ended: 0,
  statuses: { succeeded: 0, canceled: 0, aborted: 0, rejected: 0, lost: 0 },
  success_rate: null,
  duration_s: { p10: null, median: null, p90: null },
  mean_retries: null,
  errors: [],
  other_errors: 0,
});

function statistics(groups: GoalGroup[], change: Partial<Statistics> = {}): Statistics {
  const [since, until] = ["2026-11-20T00:00:00Z", "2026-11-22T00:00:00Z"];
  return { since, until, by: "day", time_zone: "UTC", total: counts(), groups, ...change };
}

const DAYS = statistics([
  { key: "2026-11-20", ...counts({ goals_path: "/goals?since=a&until=b" }) },
  { key: "2026-11-21", ...none },
]);

/** A gateway that answers with what a test gives; null is an outage. */
function answering(answer: (query: URLSearchParams) => Statistics | null, trends: DockingTrend[] = []) {
  const asked: string[] = [];
  vi.stubGlobal("fetch", async (request: Request) => {
    const { pathname, searchParams } = new URL(request.url);
    if (pathname === "/statistics/docking-time") return Response.json({ robots: trends });
    if (pathname !== "/statistics") return Response.json({}, { status: 404 });
    asked.push(searchParams.toString());
    const found = answer(searchParams);
    if (found !== null) return Response.json(found);
    const problem = { title: "t", status: 503, code: "history_unavailable", detail: "it does not answer" };
    return Response.json(problem, { status: 503 });
  });
  return asked;
}

const open = (query = "") => renderPage(fakeGateway(), {}, `/ui/statistics${query}`);
const table = async (name: string) =>
  within(await screen.findByRole("region", { name })).getByRole<HTMLTableElement>("table");
const rows = (found: HTMLTableElement) => within(found).getAllByRole("row").slice(1);
const text = (element: HTMLElement) => element.textContent?.replaceAll("\u00a0", " ");

describe("the view", () => {
  it("is read from the address and written to it", () => {
    for (const query of [
      "",
      "last=30d&by=robot&robot=%2Frobot1",
      "by=action&group=Hall+1&tag=blocked&tag=late",
      "since=2026-11-01T00%3A00%3A00Z&until=2026-11-07T00%3A00%3A00Z",
    ])
      expect(statisticsView.write(read(query)).toString()).toBe(query);
  });

  it("replaces what it does not understand", () => {
    expect(read("last=2y&by=dock&robot=&since=yesterday&group=&tag=")).toEqual(read(""));
  });

  it("asks for whole days in the reader's zone", () => {
    const midnight = (day: number) =>
      new Date(`2026-11-${String(day).padStart(2, "0")}T00:00:00`).toISOString();
    const noon = Date.parse("2026-11-21T12:00:00");
    expect(toQuery(read(""), noon)).toEqual({ by: "day", time_zone: zoneName(), since: midnight(15) });
    expect(toQuery(read("last=today&by=action&robot=/r"), noon)).toEqual({
      by: "action",
      robot: "/r",
      time_zone: zoneName(),
      since: midnight(21),
    });
    expect(toQuery(read("group=Hall+1&tag=a&tag=b"), noon)).toMatchObject({
      group: "Hall 1",
      tag: ["a", "b"],
    });
  });
});

describe("words", () => {
  it("says 100 % only where all succeeded", () => {
    expect([null, 0, 0.5, 0.99999, 1].map(percent)).toEqual(["–", "0.0 %", "50.0 %", "99.9 %", "100.0 %"]);
  });

  it("leads to the goals", () => {
    expect(goalsLink({ goals_path: "/goals?since=a" }, ["lost", "aborted"], "a b")).toBe(
      "/ui/goals?since=a&status=lost&status=aborted&error=a+b",
    );
  });
});

describe("the page", () => {
  it("has robots to choose by their names", async () => {
    answering(() => DAYS);
    const robots = [
      robot("/robot1", { display_name: "Left forklift", groups: ["Hall 1"] }),
      robot("/robot2"),
    ];
    renderPage(fakeGateway(), { robots }, "/ui/statistics");
    const select = await screen.findByRole("combobox", { name: "Robot" }, { timeout: 5000 });
    const options = within(select).getAllByRole("option");
    expect(options.map(text)).toEqual(["All robots", "/robot2", "Left forklift (/robot1)"]);
  });

  it("has a row for each day, the newest first, and every number leads to its goals", async () => {
    answering(() => DAYS);
    open();
    const [second, first] = rows(await table("By day"));
    expect(within(second as HTMLElement).queryAllByRole("link")).toEqual([]);
    const links = within(first as HTMLElement).getAllByRole("link");
    expect(links.map(text)).toEqual([
      "Fri, Nov 20",
      "20",
      "88.9 %",
      "2",
      "1",
      "1",
      "31.2",
      "1,044.9",
      "Robot was blocked",
      "Gripper jammed",
    ]);
    expect(
      links.every((link) => link.getAttribute("href")?.startsWith("/ui/goals?since=a&until=b&status=")),
    ).toBe(true);
    expect(links[3]?.getAttribute("href")).toBe("/ui/goals?since=a&until=b&status=canceled");
    expect(links[8]?.getAttribute("href")).toMatch(/&error=blocked$/);
  });

  it("sums up, and lists the errors", async () => {
    answering(() => DAYS);
    open();
    const all = within(await screen.findByRole("region", { name: "All goals" }));
    expect(all.getByRole("link", { name: "31.2 s: succeeded goals" })).toBeDefined();
    expect(all.getByText(/among the 18 that/)).toBeDefined();
    expect(rows(await table("Errors")).map(text)).toEqual([
      "Robot was blockedblocked15.0 %",
      "Gripper jammedgripper_jammed15.0 %",
      "Other errors315.0 %",
    ]);
  });

  it("asks for what is chosen", async () => {
    const asked = answering((query) =>
      query.get("by") === "robot" ? statistics([{ key: "/robot1", ...counts() }], { by: "robot" }) : DAYS,
    );
    const { user } = open("?last=30d");
    await screen.findByRole("region", { name: "By day" });
    await user.click(screen.getByRole("radio", { name: "Robot" }));
    expect(rows(await table("By robot")).map((row) => text(row)?.slice(0, 9))).toEqual(["/robot120"]);
    await user.click(screen.getByRole("radio", { name: "Dates" }));
    expect(screen.getByLabelText<HTMLInputElement>("From, day").value).toBe(dayOf(Date.now(), -29));
    await waitFor(() => expect(asked.at(-1)).toMatch(/by=robot.*until=/));
  });

  it("does not ask for more days than the gateway tells", async () => {
    const asked = answering(() => statistics([], { by: "robot" }));
    const { user } = open("?since=2020-01-01T00:00:00Z&until=2026-11-20T00:00:00Z");
    expect(await screen.findByText(/at most 400 days/)).toBeDefined();
    expect(asked).toEqual([]);
    await user.click(screen.getByRole("radio", { name: "Robot" }));
    expect(await screen.findByRole("region", { name: "By robot" })).toBeDefined();
  });

  it("says that there is nothing", async () => {
    answering(() => statistics([], { total: none }));
    open();
    expect(await screen.findByText("No goal ended")).toBeDefined();
    expect(screen.queryByRole("table")).toBeNull();
  });

  it("says why there is nothing to show, and tries again", async () => {
    let away = true;
    answering(() => (away ? null : DAYS));
    const { user } = open();
    expect((await screen.findByRole("alert")).textContent).toMatch(
      /statistics could not be loaded.*history_unav/,
    );
    away = false;
    await user.click(screen.getByRole("button", { name: "Try again" }));
    expect(await table("By day")).toBeDefined();
  });

  it("keeps what it had while the gateway is away, says so, and asks again when it is back", async () => {
    const asked = answering(() => DAYS);
    const { store } = open();
    await table("By day");
    expect(screen.getByText(/^As of/)).toBeDefined();
    store.onConnection({ kind: "closed" });
    expect(await screen.findByText(/^Not live: as of/)).toBeDefined();
    const before = asked.length;
    store.onConnection({ kind: "snapshot" });
    await waitFor(() => expect(asked.length).toBeGreaterThan(before));
  });
});

describe("the trend of the docking time", () => {
  const week = (succeeded: number, median_s: number | null) => ({
    succeeded,
    median_s,
    goals_path: "/goals?a=b",
  });
  const trend: DockingTrend = {
    robot: "/robot1",
    now: week(14, 31.2),
    before: week(18, 22.3),
    change: 0.399,
    days: [22, null, 24, 30],
  };

  it("is said where the gateway says that it is clear", () => {
    expect(trendWords(trend)).toBe(
      "Docking takes 40 % longer than last week (median 31 s, before 22 s, 14 and 18 goals).",
    );
    expect(trendWords({ ...trend, change: -0.25 })).toMatch(/^Docking takes 25 % less time than last week/);
    expect(trendWords({ ...trend, change: null })).toBe(
      "Docking takes 31 s (median of 14 goals in the last 7 days).",
    );
    expect(trendWords({ ...trend, change: null, now: week(0, null) })).toMatch(/^No docking/);
  });

  it("is drawn from 0 s on, with gaps", () => {
    const runs = sparkline(trend.days, { width: 36, height: 36, room: 3 });
    expect(runs.map((run) => run.map(({ x, y }) => [x, Math.round(y)]))).toEqual([
      [[3, 11]],
      [
        [23, 9],
        [33, 3],
      ],
    ]);
    expect(sparkline([null, null], { width: 36, height: 36, room: 3 })).toEqual([]);
  });

  it("is on the page with its goals", async () => {
    answering(() => DAYS, [trend, { ...trend, robot: "/robot2", change: null }]);
    open();
    const [first, second] = rows(await table("Docking time, by week"));
    expect(text(first as HTMLElement)).toBe("/robot131 s of 1422 s of 1840 % longer");
    expect(text(second as HTMLElement)).toMatch(/Not clear$/);
    const link = within(first as HTMLElement).getByRole("link", { name: "31 s: succeeded docking goals" });
    expect(link.getAttribute("href")).toBe("/ui/goals?a=b&status=succeeded");
  });
});

describe("the plots", () => {
  const busy = { key: "2026-11-21", ...counts({ goals_path: "/goals?since=b&until=c" }) };
  const days = statistics([...DAYS.groups.slice(0, 1), { ...none, key: "2026-11-22" }, busy]).groups;
  const plot = async (title: string) => {
    const found = (await screen.findAllByTestId("day-plot")).find((each) => text(each)?.startsWith(title));
    return within(found as HTMLElement);
  };

  it("have a bar or a point a day, where there is something to count", () => {
    expect(rateMarks(days).map(({ column, to, path }) => [column, to, path.slice(0, 24)])).toEqual([
      [0, 16 / 18, "/ui/goals?since=a&until="],
      [2, 16 / 18, "/ui/goals?since=b&until="],
    ]);
    expect(durationMarks(days).map(({ column, from, at, to }) => [column, from, at, to])).toEqual([
      [0, 27.5, 31.204, 1044.87],
      [2, 27.5, 31.204, 1044.87],
    ]);
  });

  it("put errors on each other, and the rare ones together", () => {
    const marks = errorMarks(days.slice(0, 1), ["gripper_jammed"]);
    expect(marks.map(({ kind, from, to }) => [kind, from, to])).toEqual([
      [0, 0, 1],
      [-1, 1, 5],
    ]);
    expect(marks[0]?.path).toMatch(/&error=gripper_jammed$/);
    const listed = { ...busy, other_errors: 0 };
    expect(errorMarks([listed], [])[0]?.path).toMatch(/&error=blocked&error=gripper_jammed$/);
  });

  it("have round numbers on their axes", () => {
    expect(roundTicks(33.6)).toEqual([0, 10, 20, 30, 40]);
    expect(roundTicks(0.7).at(-1)).toBeCloseTo(0.8);
    expect(roundTicks(1, true)).toEqual([0, 1]);
    expect(roundTicks(5, true)).toEqual([0, 2, 4, 6]);
    expect(roundTicks(0)).toEqual([0, 1]);
  });

  it("are reached by the keyboard, and say what is pointed at", async () => {
    answering((query) => statistics(days, { by: query.get("by") as "day" }));
    const { user } = open("?by=robot");
    const rate = await plot("Success rate");
    const [first, last] = rate.getAllByRole("link");
    expect([first?.tabIndex, last?.tabIndex]).toEqual([-1, 0]);
    last?.focus();
    expect(await rate.findByText(/^Sat, Nov 21: 88.9 %, 16 of 18 goals/)).toBeDefined();
    await user.keyboard("{ArrowLeft}{ArrowLeft}");
    expect(document.activeElement).toBe(first);
    const errors = await plot("Errors");
    expect(errors.getAllByRole("link", { name: /: Other errors, 3 goals/ })).toHaveLength(2);
  });
});
