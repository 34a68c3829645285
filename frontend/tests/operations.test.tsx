import { ClientError, type Robot } from "@dock-gateway/client";
import { notifications } from "@mantine/notifications";
import { act, fireEvent, screen, waitFor, within } from "@testing-library/react";
import { afterEach, beforeAll, beforeEach, describe, expect, it, vi } from "vitest";
import type { Gateway } from "../src/api/client";
import { divide, fewAtOnce, whyNot } from "../src/operations/operation";
import { at, goal, latched, robot, stopReport } from "./events";
import { descriptionOf, fakeGateway, loadRobotTable, renderPage } from "./page";

beforeAll(loadRobotTable);
beforeEach(() => localStorage.clear());
afterEach(() => act(() => notifications.clean()));

const one = robot("/robot1", { display_name: "Left forklift", groups: ["Hall 1"] });
const two = robot("/robot2", { groups: ["Hall 1"] });
const three = robot("/robot3", { stop: latched("Ada"), groups: ["Hall 1"] });
const busy = robot("/robot4", { goals: [goal("g4", { action_name: "/robot4/dock" })] });
const robots = [one, two, three, busy];

const button = (name: string) => screen.getByRole("button", { name });
const box = (name: string) => screen.getByRole<HTMLInputElement>("checkbox", { name });

/** The page with these robots, and the gateway of each. */
function open(robots: readonly Robot[], path = "/", change: Record<string, Partial<Gateway>> = {}) {
  const gateways = new Map(robots.map(({ name }) => [name, fakeGateway(change[name])]));
  const gateway = fakeGateway();
  const root = robot("/", { dock: null, undock: null, battery: { ...one.battery, state: null } });
  const page = renderPage(gateway, { robots: [root, ...robots] }, path, (name) => gatewayOf(name ?? "/"));
  const gatewayOf = (name: string) => gateways.get(name) ?? fakeGateway();
  return { ...page, gateway, gatewayOf };
}

async function openMenu(user: ReturnType<typeof open>["user"], name: string) {
  await user.click(button(`Commands for ${name}`));
  const menu = await screen.findByRole("menu");
  return (item: string) => within(menu).getByRole("menuitem", { name: item });
}

describe("what can be done to a robot", () => {
  it("is said for each operation, and a Stop always can", () => {
    const reasons = (each: Robot, live = true) =>
      (["dock", "undock", "cancel", "stop"] as const).map((operation) => whyNot(operation, each, live));
    expect(reasons(one)).toEqual([null, null, "No goal is running.", null]);
    expect(reasons(three)[0]).toMatch(/^The robot is stopped/);
    expect(reasons(busy)).toEqual([
      expect.stringMatching("A goal is running"),
      expect.stringMatching("A goal is running"),
      null,
      null,
    ]);
    expect(reasons(one, false).map((reason) => reason !== null)).toEqual([true, true, true, false]);
    expect(whyNot("undock", robot("/bare", { undock: null }), true)).toMatch("No server offers the action");
    expect(whyNot("dock", one, true, true)).toMatch("has not answered yet");
  });

  it("leaves goals of other actions out of the way, but cancels them", () => {
    const counting = robot("/a", { goals: [goal("f", { action_name: "/a/fibonacci" })] });
    expect([whyNot("dock", counting, true), whyNot("cancel", counting, true)]).toEqual([null, null]);
    const canceling = robot("/a", { goals: [goal("f", { action_name: "/a/dock", status: "canceling" })] });
    expect(whyNot("cancel", canceling, true)).toBe("The goal is being canceled.");
  });

  it("divides several into those that can and those that cannot", () => {
    const { able, unable } = divide("dock", robots, true);
    expect(able.map(({ name }) => name)).toEqual(["/robot1", "/robot2"]);
    expect(unable.map(({ name }) => name)).toEqual(["/robot3", "/robot4"]);
  });

  it("is asked of a few robots at the same time", async () => {
    let running = 0;
    let most = 0;
    const done: number[] = [];
    await fewAtOnce([...Array(20).keys()], async (item) => {
      running += 1;
      most = Math.max(most, running);
      await Promise.resolve();
      running -= 1;
      done.push(item);
    });
    expect(most).toBe(4);
    expect(done).toHaveLength(20);
  });
});

describe("the menu of a row", () => {
  it("asks before a real robot moves, as its page does", async () => {
    const { user, gatewayOf } = open(robots);
    const item = await openMenu(user, "Left forklift");
    await user.click(item("Undock"));
    const dialog = await screen.findByRole("dialog", { name: "Undock Left forklift (/robot1)?" });
    expect(gatewayOf("/robot1").undock).not.toHaveBeenCalled();
    await user.click(within(dialog).getByRole("button", { name: "Undock" }));
    expect(gatewayOf("/robot1").undock).toHaveBeenCalledTimes(1);
    expect(await screen.findByText("Undock: Left forklift (/robot1) accepted")).toBeDefined();
  });

  it("asks nothing where that is switched off, nor for a simulated robot", async () => {
    const simulated = robot("/sim", { simulated: true });
    const { user, gatewayOf } = open([...robots, simulated]);
    await user.click((await openMenu(user, "/sim"))("Dock"));
    expect(gatewayOf("/sim").dock).toHaveBeenCalledWith(null);
    act(() => {
      localStorage.setItem("dock-gateway-ask-before-moving", "false");
      window.dispatchEvent(
        new CustomEvent("mantine-local-storage", {
          detail: { key: "dock-gateway-ask-before-moving", value: false },
        }),
      );
    });
    await user.click((await openMenu(user, "/robot2"))("Dock"));
    expect(gatewayOf("/robot2").dock).toHaveBeenCalledTimes(1);
  });

  it("says why something cannot be done, and does not do it", async () => {
    const { user, gatewayOf } = open(robots);
    const dock = (await openMenu(user, "/robot3"))("Dock");
    expect(dock.ariaDisabled).toBe("true");
    expect(descriptionOf(dock)).toMatch("The robot is stopped");
    await user.click(dock);
    expect(gatewayOf("/robot3").dock).not.toHaveBeenCalled();
  });

  it("stops at once, and cancels what runs", async () => {
    const { user, gateway } = open(robots);
    await user.click((await openMenu(user, "/robot2"))("Stop"));
    expect(gateway.stop).toHaveBeenCalledExactlyOnceWith(expect.any(String), ["/robot2"]);
    expect(await screen.findByText("Stopped /robot2")).toBeDefined();
    const fetched = vi.fn(async (_: Request) => Response.json(goal("g4", { status: "canceling" })));
    vi.stubGlobal("fetch", fetched);
    await user.click((await openMenu(user, "/robot4"))("Cancel"));
    await waitFor(() => expect(fetched).toHaveBeenCalledTimes(1));
    expect(fetched.mock.calls[0]?.[0].url).toBe("http://gateway:8000/goals/g4/cancel");
  });
});

describe("the robots that are selected", () => {
  const selectAll = (count: number) => box(`Select all ${count} that are listed`);

  it("of a group are asked about once, and each tells what came of it", async () => {
    const dock = vi.fn().mockRejectedValue(new ClientError("goal_rejected", "Rejected", "too far away"));
    const { user, gatewayOf } = open(robots, "/?group=Hall+1", { "/robot2": { dock } });
    await user.click(selectAll(3));
    expect(screen.getByText("3 selected")).toBeDefined();
    await user.click(button("Dock"));
    const dialog = await screen.findByRole("dialog", { name: "Dock 2 robots?" });
    expect(within(dialog).getByText("/robot2, Left forklift (/robot1)")).toBeDefined();
    expect(within(dialog).getByRole("listitem").textContent).toBe(
      "The robot is stopped. Release the stop first. /robot3",
    );
    expect(document.activeElement?.textContent).toBe("Leave them there");
    await user.click(within(dialog).getByRole("button", { name: "Dock 2 robots" }));
    expect(await screen.findByText("Dock: 1 of 2 robots accepted")).toBeDefined();
    expect(screen.getByText("Accepted: Left forklift")).toBeDefined();
    expect(screen.getByText(/^Rejected: too far away \(goal_rejected\)/).textContent).toMatch("/robot2");
    expect(gatewayOf("/robot1").dock).toHaveBeenCalledTimes(1);
    expect(gatewayOf("/robot3").dock).not.toHaveBeenCalled();
  });

  it("are stopped at once by one request, and what did not work is said for each", async () => {
    const { user, gateway } = open(robots);
    const failed = [{ action_name: null, robot: "/robot2", code: "publish_failed", detail: "no publisher" }];
    vi.mocked(gateway.stop).mockResolvedValueOnce(stopReport({ failed }));
    await user.click(box("Select Left forklift"));
    await user.click(box("Select /robot2"));
    await user.click(within(screen.getByRole("group", { name: /selected robots/ })).getByText("Stop"));
    expect(screen.queryByRole("dialog")).toBeNull();
    expect(gateway.stop).toHaveBeenCalledExactlyOnceWith(expect.any(String), ["/robot2", "/robot1"]);
    expect(await screen.findByText("Stop did not reach every robot")).toBeDefined();
    expect(screen.getByText(/^\/robot2: no publisher/)).toBeDefined();
  });

  it("are stopped as everything else is where they are all robots", async () => {
    const { user, gateway } = open([one, two]);
    await user.click(selectAll(2));
    await user.click(within(screen.getByRole("group", { name: /selected robots/ })).getByText("Stop"));
    expect(gateway.stop).toHaveBeenCalledExactlyOnceWith(expect.any(String), []);
  });

  it("are not sent what a Stop in between has made wrong", async () => {
    let answer = () => {};
    const many = Array.from({ length: 6 }, (_, index) => robot(`/r${index}`));
    const waiting = () => new Promise<never>((_, reject) => (answer = () => reject(new Error("late"))));
    const change = Object.fromEntries(many.slice(0, 4).map(({ name }) => [name, { dock: vi.fn(waiting) }]));
    const { store, user, gatewayOf } = open(many, "/", change);
    await user.click(selectAll(6));
    await user.click(button("Dock"));
    await user.click(await screen.findByRole("button", { name: "Dock 6 robots" }));
    expect(gatewayOf("/r3").dock).toHaveBeenCalledTimes(1);
    const stopped = many.map((each) => ({ ...each, stop: latched("Ada") }));
    act(() => store.onEvent({ type: "robots", time: at(1), robots: stopped, gone: [] }));
    await waitFor(() => expect(screen.getAllByText("Stopped by Ada")).toHaveLength(6));
    act(() => answer());
    expect(await screen.findByText("Dock: 3 of 6 robots answered")).toBeDefined();
    expect(gatewayOf("/r4").dock).not.toHaveBeenCalled();
    expect(gatewayOf("/r5").dock).not.toHaveBeenCalled();
  });

  it("are chosen in ranges with Shift, and are those that are listed", async () => {
    const { user } = open(robots);
    fireEvent.click(box("Select /robot2"));
    fireEvent.click(box("Select /robot4"), { shiftKey: true });
    expect(screen.getByText("3 selected")).toBeDefined();
    expect(selectAll(4).indeterminate).toBe(true);
    await user.click(button("Select all 4"));
    expect(screen.getByText("4 selected")).toBeDefined();
    await user.click(button("1 Stopped"));
    expect(screen.getByText("1 selected")).toBeDefined();
    await user.click(button("Clear the selection"));
    expect(screen.getByText("1 of 4 robots")).toBeDefined();
    expect(screen.queryByRole("group", { name: /selected robots/ })).toBeNull();
  });
});

describe("the table of robots", () => {
  it("has the columns that were chosen in this browser", async () => {
    const { user } = open(robots);
    const names = () => screen.getAllByRole("columnheader").map((header) => header.textContent?.slice(0, -1));
    expect(names()).toContain("Connection");
    await user.click(button("Columns"));
    await user.click(await screen.findByRole("menuitemcheckbox", { name: "Connection" }));
    await waitFor(() => expect(names()).not.toContain("Connection"));
    expect(JSON.parse(localStorage.getItem("dock-gateway-overview-columns") ?? "")).toEqual(["link"]);
    await user.click(screen.getByRole("menuitemcheckbox", { name: "Connection" }));
    await waitFor(() => expect(names()).toContain("Connection"));
  });

  it("has those of many robots on the page that are in sight, and tells how many there are", () => {
    open(Array.from({ length: 300 }, (_, index) => robot(`/r${index}`)));
    const table = screen.getByRole("table", { name: "Robots" });
    expect(table.ariaRowCount ?? table.getAttribute("aria-rowcount")).toBe("301");
    const rows = within(table).getAllByRole("rowheader");
    expect(rows.length).toBeLessThan(60);
    expect(screen.getByTestId("robot /r3").getAttribute("aria-rowindex")).toBe("5");
  });
});
