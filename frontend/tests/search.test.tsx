import { notifications } from "@mantine/notifications";
import { act, fireEvent, screen, waitFor, within } from "@testing-library/react";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { find, goalIdOf, type Sources } from "../src/search/items";
// Loaded on first use by the page.
import "../src/search/Palette";
import { fibonacciAction, goal, latched, robot } from "./events";
import { fakeGateway, pressEscape, renderPage } from "./page";

beforeEach(() => localStorage.clear());
afterEach(() => act(() => notifications.clean()));

const left = robot("/robot1", { display_name: "Left forklift", groups: ["Hall 1"] });
const two = robot("/robot2", { groups: ["Hall 1"] });
const ten = robot("/robot10", { stop: latched("Ada") });
const twenty = robot("/robot20");
const sources: Sources = {
  robots: [ten, twenty, two, left],
  groups: ["Hall 1"],
  actions: [fibonacciAction("/fibonacci")],
  goals: [],
  pages: [
    { to: "/", name: "Overview" },
    { to: "/ui/goals", name: "Goals" },
  ],
  help: [{ to: "/ui/help/stop#the-latch", title: "The latch", page: "Stop" }],
  live: true,
};

/** What is found, as `Group: first, second`. */
const found = (text: string, change: Partial<Sources> = {}) =>
  find(text, { ...sources, ...change }).map(
    ({ label, items }) => `${label}: ${items.map((item) => item.label).join(", ")}`,
  );

describe("what is found", () => {
  it("begins with the robots that are called so, then those that begin with it", () => {
    expect(found("robot2")[0]).toBe("Robots: /robot2, /robot20");
    expect(found("")).toEqual([
      "Robots: /robot2, /robot10, /robot20, Left forklift",
      "Groups: Hall 1",
      "Pages: Overview, Goals",
    ]);
  });

  it("is a page, a group or an action by a part of the name", () => {
    expect(found("goal")).toEqual(["Pages: Goals"]);
    expect(found("hall")).toEqual(expect.arrayContaining(["Groups: Hall 1"]));
    expect(found("fibo")).toEqual(["Actions: /fibonacci"]);
    const [group] = find("hall", sources).filter(({ label }) => label === "Groups");
    expect(group?.items[0]?.does).toEqual({ to: "/?group=Hall%201" });
  });

  it("is a heading of the help, once enough of it is typed", () => {
    expect(found("latch")).toEqual(["Help: The latch"]);
    expect(found("la")).not.toEqual(expect.arrayContaining(["Help: The latch"]));
  });

  it("is a command where a verb is typed", () => {
    expect(found("dock robot2")).toEqual(["Commands: Dock /robot2, Dock /robot20"]);
    expect(found("cancel left")).toEqual(["Commands: Cancel Left forklift"]);
    expect(found("stop")[0]).toMatch(/^Commands: Stop every robot, Stop \/robot2,/);
    expect(found("stop 2")).toEqual(["Commands: Stop /robot2, Stop /robot20"]);
  });

  it("offers every command for few robots, after their pages, and says why one cannot be used", () => {
    expect(found("left")).toEqual([
      "Robots: Left forklift",
      "Commands: Dock Left forklift, Undock Left forklift, Cancel Left forklift, Stop Left forklift",
    ]);
    const [{ items } = { items: [] }] = find("dock robot10", sources);
    expect(items[0]?.description).toMatch("The robot is stopped");
  });

  it("is a goal by the beginning of its id", () => {
    expect([goalIdOf(" 4F1c "), goalIdOf("4f1"), goalIdOf("face-to-face")]).toEqual(["4F1c", null, null]);
    const goals = [goal("4f1c0000-0000-4000-8000-000000000000", { status: "succeeded" })];
    expect(found("4f1c", { goals, robots: [] })).toEqual(["Goals: Goal 4f1c0000"]);
  });
});

describe("the search", () => {
  const box = () => screen.findByRole<HTMLInputElement>("combobox", { name: "Search and commands" });
  const list = () => within(screen.getByRole("listbox", { name: "Found" }));
  const options = () =>
    list()
      .getAllByRole("option")
      .map(({ textContent }) => textContent);

  function open(answers: (url: URL) => unknown = () => ({ actions: [], goals: [], rules: [] })) {
    const fetched: string[] = [];
    vi.stubGlobal("fetch", async (request: Request) => {
      const url = new URL(request.url);
      fetched.push(url.pathname + url.search);
      return Response.json(answers(url));
    });
    const one = fakeGateway();
    const gateway = fakeGateway();
    const page = renderPage(gateway, { robots: [...sources.robots] }, "/", () => one);
    fireEvent.keyDown(document.documentElement, { key: "k", code: "KeyK", ctrlKey: true });
    return { ...page, one, gateway, fetched };
  }

  it("opens by Ctrl+K and leads to a robot by keyboard alone", async () => {
    const { user } = open();
    await user.type(await box(), "left");
    await waitFor(() => expect(options()[0]).toMatch(/^Left forklift/));
    await waitFor(() => expect(list().getAllByRole("option")[0]?.ariaSelected).toBe("true"));
    const active = (await box()).getAttribute("aria-activedescendant");
    expect(document.getElementById(active ?? "")?.textContent).toMatch(/^Left forklift/);
    await user.keyboard("{Enter}");
    expect(await screen.findByRole("heading", { level: 1, name: "Left forklift" })).toBeDefined();
    await waitFor(() => expect(screen.queryByRole("combobox", { name: "Search and commands" })).toBeNull());
  });

  it("asks before a real robot moves, as the buttons do", async () => {
    const { user, one } = open();
    await user.type(await box(), "dock left");
    await waitFor(() => expect(options()).toHaveLength(1));
    await user.keyboard("{Enter}");
    const dialog = await screen.findByRole("dialog", { name: "Dock Left forklift (/robot1)?" });
    expect(one.dock).not.toHaveBeenCalled();
    await user.click(within(dialog).getByRole("button", { name: "Dock" }));
    expect(one.dock).toHaveBeenCalledTimes(1);
  });

  it("stops a robot without a question, and every robot", async () => {
    const { user, gateway } = open();
    await user.type(await box(), "stop robot2");
    await waitFor(() => expect(options()).toHaveLength(2));
    await user.keyboard("{Enter}");
    await user.click(screen.getByRole("button", { name: "Search and commands" }));
    await user.type(await box(), "stop");
    await user.keyboard("{Enter}");
    await waitFor(() => expect(gateway.stop).toHaveBeenCalledTimes(2));
    expect(vi.mocked(gateway.stop).mock.calls.map(([, robots]) => robots)).toEqual([["/robot2"], []]);
  });

  it("asks the gateway for goals by the beginning of their id", async () => {
    const id = "4f1c0000-0000-4000-8000-000000000000";
    const { user, fetched } = open(({ pathname }) =>
      pathname === "/goals" ? { goals: [goal(id)], next_cursor: null } : { actions: [] },
    );
    await user.type(await box(), "4f1c");
    expect(await screen.findByRole("option", { name: /^Goal 4f1c0000/ })).toBeDefined();
    expect(fetched).toContain("/goals?id=4f1c&limit=50");
    await waitFor(() => expect(list().getAllByRole("option")[0]?.ariaSelected).toBe("true"));
  });

  it("closes with one Escape, and stops with two, as everywhere", async () => {
    const { user, gateway } = open();
    await user.type(await box(), "left");
    pressEscape(1e9);
    await waitFor(() => expect(screen.queryByRole("combobox", { name: "Search and commands" })).toBeNull());
    expect(gateway.stop).not.toHaveBeenCalled();
    await user.click(screen.getByRole("button", { name: "Search and commands" }));
    await box();
    pressEscape(2e9);
    expect(gateway.stop).not.toHaveBeenCalled();
    pressEscape(2e9 + 500);
    expect(gateway.stop).toHaveBeenCalledTimes(1);
  });
});
