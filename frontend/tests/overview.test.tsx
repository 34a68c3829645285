import type { BatteryState, Robot } from "@dock-gateway/client";
import { act, cleanup, screen, waitFor, within } from "@testing-library/react";
import { beforeAll, beforeEach, describe, expect, it, vi } from "vitest";
import { session } from "../src/api/session";
import { listed, overviewView } from "../src/pages/overview/list";
import { alert, at, battery, goal, latched, robot, server } from "./events";
import { fakeGateway, loadRobotTable, renderPage } from "./page";

beforeAll(loadRobotTable);
beforeEach(() => localStorage.clear());

const one = robot("/robot1", {
  docked: true,
  last_goal: goal("l", { status: "succeeded", action_name: "/robot1/dock" }),
});
const two = robot("/robot2", {
  goals: [goal("g", { action_name: "/robot2/dock", stage: "CONTROLLING" })],
  battery: {
    ...one.battery,
    state: { ...battery, percentage: 0.81, power_supply_status: 1 },
    percentage: 0.81,
  },
});
const ten = robot("/robot10", {
  stop: latched("Ada"),
  dock: { ...server, action_name: "/robot10/dock", answering: false },
  battery: {
    state: { ...battery, percentage: null },
    percentage: null,
    implausible: [],
    received_at: at(-60),
    stale: true,
    stale_after_s: 2,
    low_below: 0.2,
  },
});
const empty = robot("/", {
  dock: { ...server, available: false, answering: false },
  undock: null,
  battery: {
    state: null,
    percentage: null,
    implausible: [],
    received_at: null,
    stale: false,
    stale_after_s: 2,
    low_below: 0.2,
  },
});
const robots = [empty, one, two, ten];

const rows = () =>
  within(screen.getByRole("table"))
    .getAllByRole("rowheader")
    .map((row) => row.textContent);
const order = (...names: string[]) => names.map((name) => expect.stringMatching(`^${name}\\D`));
const row = (name: string) => screen.getByTestId(`robot ${name}`);

describe("the overview of several robots", () => {
  it("has a row for each, but not for the configured one where that is not there", () => {
    vi.useFakeTimers({ now: Date.now(), toFake: ["Date", "performance"] }); // a slow machine makes no battery stale
    renderPage(fakeGateway(), { robots });
    expect(rows().map((text) => text?.match(/^\/robot\d+/)?.[0])).toEqual(["/robot1", "/robot2", "/robot10"]);
    expect(row("/robot1").textContent).toMatch(
      /Docked.*24 %.*not charging.*now.*Idle.*Reached the dock.*Connected/,
    );
    expect(row("/robot2").textContent).toMatch(/Not docked.*81 %.*charging.*Dock: Controlling.*No goals yet/);
    expect(row("/robot10").textContent).toMatch(/2.16 V.*stale: .* ago.*Stopped by Ada.*Silent/);
  });

  it("calls a battery low below the gateway's limit, unless it charges", () => {
    const at35 = (name: string, low_below: number, power_supply_status = 2) => {
      const state = { ...battery, percentage: 0.35, power_supply_status };
      return robot(name, { battery: { ...one.battery, state, percentage: 0.35, low_below } });
    };
    renderPage(fakeGateway(), { robots: [at35("/a", 0.4), at35("/b", 0.3), at35("/c", 0.4, 1)] });
    expect(["/a", "/b", "/c"].map((name) => /low/.test(row(name).textContent ?? ""))).toEqual([
      true,
      false,
      false,
    ]);
  });

  it("shows no percentage that cannot be right, and what charges without a status", () => {
    const battery = { ...one.battery, percentage: null };
    const wrong = { ...battery.state, percentage: 12 } as BatteryState;
    const quiet = { ...battery.state, percentage: 0.1, power_supply_status: 0 } as BatteryState;
    const robots = [
      robot("/wrong", { battery: { ...battery, state: wrong } }),
      robot("/quiet", { charging: true, battery: { ...battery, state: quiet, percentage: 0.1 } }),
    ];
    renderPage(fakeGateway(), { robots });
    expect(row("/wrong").textContent).toMatch(/2.16 V/);
    expect(row("/wrong").textContent).not.toMatch(/%/);
    expect(row("/quiet").textContent).toMatch(/10 %.*charging/);
    expect(row("/quiet").textContent).not.toMatch(/low/);
  });

  it("calls a robot unreachable that was switched off, and counts it so", () => {
    const battery = { ...one.battery, stale: true };
    renderPage(fakeGateway(), { robots: [one, robot("/dead", { dock: null, undock: null, battery })] });
    expect(row("/dead").textContent).toMatch(/Unknown.*Unreachable$/);
    expect(row("/dead").textContent).not.toMatch(/Idle|Battery only/);
    expect(screen.getByRole("button", { name: "1 Unreachable" })).toBeDefined();
  });

  it("leaves a robot in its place when it has an alert, and says so in words", () => {
    const alerts = [
      alert("a", { robot: "/robot10" }),
      alert("b", { robot: "/robot2", severity: "critical" }),
    ];
    renderPage(fakeGateway(), { robots, alerts });
    expect(rows()).toEqual([
      expect.stringMatching(/^\/robot1\D/),
      expect.stringMatching(/^Critical alert: \/robot2/),
      expect.stringMatching(/^Warning: \/robot10/),
    ]);
  });

  it("sorts by a column, the other way round, and no more", async () => {
    const { user } = renderPage(fakeGateway(), { robots });
    const header = () => screen.getByRole("columnheader", { name: "Battery" });
    const press = () => user.click(screen.getByRole("button", { name: "Battery" }));
    await press();
    expect(header().getAttribute("aria-sort")).toBe("ascending");
    expect(rows()).toEqual(order("/robot1", "/robot2", "/robot10"));
    await press();
    expect(header().getAttribute("aria-sort")).toBe("descending");
    expect(rows()).toEqual(order("/robot10", "/robot2", "/robot1"));
    await press();
    expect(header().getAttribute("aria-sort")).toBe("none");
  });

  it("is narrowed by what robots are like, and by name; shows all again", async () => {
    const { user } = renderPage(fakeGateway(), { robots });
    await user.click(screen.getByRole("button", { name: "1 Stopped" }));
    expect(rows()).toEqual([expect.stringMatching("/robot10")]);
    await user.keyboard("/2");
    expect(screen.getByText("No robot is like that now.")).toBeDefined();
    await user.click(screen.getByRole("button", { name: "Show all 3" }));
    expect(rows()).toHaveLength(3);
  });

  it("has saved views, each with its columns, whatever this browser shows otherwise", async () => {
    const fleet = [robot("/robot1", { groups: ["Hall 1"] }), robot("/robot2")];
    const { user } = renderPage(fakeGateway(), { robots: fleet }, "/?group=Hall+1&sort=battery");
    const has = (name: string) => screen.queryByRole("columnheader", { name }) !== null;
    const toggle = async (name: string) => {
      await user.click(screen.getByRole("button", { name: "Columns" }));
      await user.click(await screen.findByRole("menuitemcheckbox", { name }));
      await user.keyboard("{Escape}");
    };
    await toggle("Dock status");
    await user.click(screen.getByRole("button", { name: "Views" }));
    expect(screen.getByText(/in this browser only/)).toBeDefined();
    await user.type(screen.getByLabelText("Name of the view"), "Hall{Enter}");
    await user.keyboard("{Escape}");
    await toggle("Dock status");
    await user.selectOptions(screen.getByLabelText("Group"), "");
    expect(has("Dock status")).toBe(true);
    expect(rows()).toHaveLength(2);
    await user.click(screen.getByRole("button", { name: "Views" }));
    await user.click(screen.getByRole("link", { name: "Hall" }));
    expect(rows()).toHaveLength(1);
    expect(has("Dock status")).toBe(false);
    await toggle("Connection");
    expect(has("Connection")).toBe(false);
    await user.click(screen.getByRole("button", { name: "Views" }));
    expect(screen.getByRole("link", { name: "Hall" }).ariaCurrent).toBeNull();
    expect(localStorage.getItem("dock-gateway-overview-columns")).toBe("[]");
  });

  it("does with damaged storage what it does without", async () => {
    for (const kept of ["{", "7", '{"a": 1}', '["nothing", null]']) {
      localStorage.setItem("dock-gateway-overview-columns", kept);
      localStorage.setItem("dock-gateway-views-overview", kept);
      const { user } = renderPage(fakeGateway(), { robots });
      await user.click(screen.getByRole("button", { name: "Views" }));
      expect(screen.queryByRole("list", { name: "Saved views" })).toBeNull();
      expect(screen.getByRole("columnheader", { name: "Connection" })).toBeDefined();
      cleanup();
    }
  });

  it("leads to each robot's page", async () => {
    const { user } = renderPage(fakeGateway(), { robots });
    await user.click(screen.getByRole("link", { name: "/robot2" }));
    expect(await screen.findByRole("heading", { level: 1, name: "/robot2" })).toBeDefined();
  });

  it("renders those anew that changed, and no others", async () => {
    let reads = 0;
    const watched = {
      ...one,
      get simulated() {
        reads += 1;
        return false;
      },
    };
    const many = Array.from({ length: 50 }, (_, index) => robot(`/other${index}`));
    const { store } = renderPage(fakeGateway(), { robots: [watched, ...many] });
    const before = reads;
    expect(before).toBeGreaterThan(0);
    for (const percentage of [0.5, 0.6]) {
      const changed = many.map((each) => ({
        ...each,
        battery: { ...each.battery, state: { ...battery, percentage }, percentage },
      }));
      act(() => store.onEvent({ type: "robots", time: new Date().toISOString(), robots: changed, gone: [] }));
      await waitFor(() => expect(row("/other49").textContent).toMatch(`${percentage * 100} %`));
    }
    expect(reads).toBe(before);
  });
});

describe("the overview of one robot", () => {
  it("is that robot's page: who it is, whether it is docked, and all that there is of it", () => {
    renderPage(fakeGateway(), { robots: [robot("/", { docked: false })] });
    expect(screen.getAllByRole("heading", { level: 1 }).map((heading) => heading.textContent)).toEqual([
      "Robot",
    ]);
    expect(screen.getByTestId("place").textContent).toBe("Not docked");
    expect(screen.getByRole("tab", { name: "Operate", selected: true })).toBeDefined();
    expect(screen.getByRole("button", { name: "Dock" })).toBeDefined();
    expect(screen.queryByRole("table", { name: /robots/ })).toBeNull();
    expect(screen.queryByRole("navigation", { name: "Breadcrumb" })).toBeNull();
  });

  it("becomes that of all when there are more, but not under somebody's hands", async () => {
    const tell = (each: Robot) => ({ type: "robots" as const, time: at(1), robots: [each], gone: [] });
    const first = renderPage(fakeGateway(), { robots: [empty, one] });
    act(() => first.store.onEvent(tell(two)));
    expect(await screen.findByTestId("robot /robot2")).toBeDefined();
    document.body.replaceChildren();
    const { store, user } = renderPage(fakeGateway(), { robots: [empty, two] });
    await user.click(screen.getByText("Battery", { selector: "h2" }));
    act(() => store.onEvent(tell(one)));
    await user.click(await screen.findByRole("button", { name: "Show all" }));
    expect(rows()).toHaveLength(2);
  });

  it("teaches what to do where there is none", () => {
    renderPage(fakeGateway(), { robots: [empty] });
    expect(screen.getByRole("heading", { name: "No robot yet" })).toBeDefined();
    expect(screen.getByText("connect_to_charging_dock_server")).toBeDefined();
  });

  it("is not known before the gateway has told", () => {
    renderPage(fakeGateway(), null);
    expect(screen.getByLabelText("The robots are not known yet")).toBeDefined();
  });
});

describe("the page of a robot", () => {
  const tab = (name: string) => screen.getByRole("tab", { name });

  it("has what developers need in a tab, which is in the address, and by keyboard", async () => {
    const { user } = renderPage(fakeGateway(), { robots }, "/ui/robot?robot=/robot1");
    expect(tab("Operate").ariaSelected).toBe("true");
    expect(screen.queryByRole("heading", { name: "From a terminal" })).toBeNull();
    tab("Operate").focus();
    await user.keyboard("{ArrowRight}");
    expect(tab("Developer").ariaSelected).toBe("true");
    expect(await screen.findByRole("heading", { name: "From a terminal" })).toBeDefined();
    expect(screen.queryByRole("button", { name: "Dock" })).toBeNull();
    await user.keyboard("{ArrowLeft}");
    expect(screen.getByRole("button", { name: "Dock" })).toBeDefined();
  });

  it("leads back to the overview, and to each of the others on the same tab", async () => {
    const { user } = renderPage(fakeGateway(), { robots }, "/ui/robot?robot=/robot2&tab=developer");
    const switcher = () => screen.findByRole("combobox", { name: "Switch robot" });
    await user.click(await switcher());
    const list = within(await screen.findByRole("listbox", { name: "Switch robot" }));
    expect(list.getAllByRole("option").map(({ textContent }) => textContent)).toEqual([
      "/robot1",
      "/robot10",
    ]);
    await user.type(await switcher(), "10{Enter}");
    expect(await screen.findByRole("heading", { level: 1, name: "/robot10" })).toBeDefined();
    expect(tab("Developer").ariaSelected).toBe("true");
    expect(document.activeElement).toBe(await switcher());
    expect(await switcher()).toHaveProperty("value", "");
    const breadcrumb = within(screen.getByRole("navigation", { name: "Breadcrumb" }));
    await user.click(breadcrumb.getByRole("link", { name: "Overview" }));
    expect(await screen.findByRole("heading", { level: 1, name: "Overview" })).toBeDefined();
  });

  it("has no switch where there is no other robot", () => {
    renderPage(fakeGateway(), { robots: [empty, one] }, "/ui/robot?robot=/robot1");
    expect(screen.queryByRole("combobox", { name: "Switch robot" })).toBeNull();
  });

  it("says that it is unreachable, as the overview does", () => {
    const battery = { ...one.battery, stale: true };
    const dead = robot("/dead", { dock: null, undock: null, battery });
    renderPage(fakeGateway(), { robots: [one, dead] }, "/ui/robot?robot=/dead");
    expect(screen.getByText("Unreachable")).toBeDefined();
  });

  it("says that no such robot is known, offers those that are, and waits for it", async () => {
    const { store } = renderPage(fakeGateway(), { robots: [empty, one] }, "/ui/robot?robot=/nix");
    expect(screen.getByText("No robot /nix is known")).toBeDefined();
    expect(screen.getByRole("link", { name: "/robot1" })).toBeDefined();
    expect(screen.queryByRole("button", { name: "Dock" })).toBeNull();
    const nix = { type: "robots" as const, time: at(1), robots: [robot("/nix")], gone: [] };
    act(() => store.onEvent(nix));
    expect(await screen.findByRole("button", { name: "Dock" })).toBeDefined();
    expect(screen.queryByText("No robot /nix is known")).toBeNull();
    act(() => store.onEvent({ ...nix, robots: [], gone: ["/nix"] }));
    expect(await screen.findByText("/nix has left the ROS graph")).toBeDefined();
    expect(screen.getByRole("button", { name: "Dock" })).toBeDefined();
  });
});

describe("alerts", () => {
  const low = alert("low", { started_at: at(1) });
  const lost = alert("lost", {
    kind: "goal_lost",
    severity: "critical",
    title: "Goal lost",
    detail: "Look at the robot.",
    goal_id: "g1",
  });
  const seen = { by: "Grace", acknowledged_at: at(5) };

  function answers(body: unknown, status = 200) {
    const fetched = vi.fn(async (_request: Request) => Response.json(body, { status }));
    vi.stubGlobal("fetch", fetched);
    return fetched;
  }
  const items = () => within(screen.getByRole("region", { name: "Alerts" })).getAllByRole("listitem");

  it("come first, the most urgent on top, and are counted on every page and in its title", () => {
    renderPage(fakeGateway(), { robots, alerts: [low, lost, alert("old", { acknowledged: seen })] });
    expect(items().map((item) => item.textContent)).toEqual([
      expect.stringMatching(/^Goal lost: \/robot1Look at the robot.Critical, since .* See the goal/),
      expect.stringMatching(/^Low battery: \/robot1/),
    ]);
    expect(screen.getByTestId("alert-count").textContent).toBe("2 alerts, critical");
    expect(document.title).toBe("(2) Overview · dock-gateway");
  });

  it("of the gateway itself lead to no robot", () => {
    const ours = alert("ours", { kind: "history_lost", robot: null, title: "History lost", detail: "Look." });
    renderPage(fakeGateway(), { robots, alerts: [ours] });
    expect(items()[0]?.textContent).toMatch(/^History lostLook\.Warning, since/);
    expect(within(items()[0] as HTMLElement).queryByRole("link")).toBeNull();
    expect(screen.getByRole("button", { name: "Acknowledge: History lost" })).toBeDefined();
    expect(rows()[0]).toMatch(/^\/robot1/);
  });

  it("are narrowed by the group filter, and those that are hidden are counted", async () => {
    const fleet = [
      robot("/hall/robot1", { groups: ["Hall 1"] }),
      robot("/robot2", { groups: ["Hall 2"] }),
      robot("/robot3", { groups: ["Hall 3"] }),
    ];
    const stop = { kind: "stop_latched", severity: "critical", title: "Stopped" } as const;
    const alerts = [
      alert("low", { robot: "/hall/robot1" }),
      alert("ours", { robot: null, title: "History lost" }),
      alert("hall", { ...stop, robot: "/hall", detail: "/hall and 1 below it was stopped." }),
      alert("other", { ...stop, robot: "/robot2" }),
      alert("seen", { robot: "/robot2", acknowledged: seen }),
    ];
    const { user } = renderPage(fakeGateway(), { robots: fleet, alerts }, "/?group=Hall+1");
    const region = within(screen.getByRole("region", { name: "Alerts" }));
    expect(items().map((item) => item.textContent)).toEqual([
      expect.stringMatching(/^Stopped: \/hall/),
      expect.stringMatching(/^(Low battery|History lost)/),
      expect.stringMatching(/^(Low battery|History lost)/),
    ]);
    expect(region.getByText("3 not acknowledged")).toBeDefined();
    expect(
      region.getByText("2 alerts of other robots are hidden by the group filter, 1 critical."),
    ).toBeDefined();
    expect(screen.getByTestId("alert-count").textContent).toBe("4 alerts, critical");
    await user.selectOptions(await screen.findByLabelText("Group"), "Hall 3");
    expect(items().map((item) => item.textContent)).toEqual([expect.stringMatching(/^History lost/)]);
    await user.selectOptions(screen.getByLabelText("Group"), "");
    expect(items()).toHaveLength(4);
    expect(region.queryByText(/group filter/)).toBeNull();
  });

  it("say that a group has none", () => {
    const fleet = [robot("/robot1", { groups: ["Hall 1"] }), robot("/robot2", { groups: ["Hall 2"] })];
    renderPage(fakeGateway(), { robots: fleet, alerts: [low] }, "/?group=Hall+2");
    const region = within(screen.getByRole("region", { name: "Alerts" }));
    expect(region.getByText("No active alerts in Hall 2.")).toBeDefined();
    expect(region.getByText("1 alert of another robot is hidden by the group filter.")).toBeDefined();
  });

  it("are counted elsewhere, too", () => {
    renderPage(fakeGateway(), { robots, alerts: [low] }, "/ui/robot");
    expect(screen.getByTestId("alert-count").textContent).toBe("1 alert");
    expect(document.title).toMatch(/^\(1\) Robot/);
  });

  it("are acknowledged with a name, which is asked for once", async () => {
    const fetched = answers({ ...low, acknowledged: { by: "Ada", acknowledged_at: at(9) } });
    const { user } = renderPage(fakeGateway(), { robots, alerts: [low, lost] });
    await user.click(screen.getByRole("button", { name: "Acknowledge: Low battery: /robot1" }));
    const dialog = await screen.findByRole("dialog", { name: "Acknowledge as" });
    await user.type(within(dialog).getByLabelText("Your name"), "Ada{Enter}");
    await waitFor(() => expect(items()).toHaveLength(1));
    const [request] = fetched.mock.calls[0] ?? [];
    expect([request?.method, request?.url]).toEqual([
      "PUT",
      "http://gateway:8000/alerts/low/acknowledgement",
    ]);
    expect(await request?.json()).toEqual({ by: "Ada" });
    await user.click(screen.getByRole("button", { name: "Show 1 more" }));
    expect(items()[1]?.textContent).toMatch(/Acknowledged by Ada at/);
    await user.click(screen.getByRole("button", { name: "Acknowledge: Goal lost: /robot1" }));
    await waitFor(() => expect(fetched).toHaveBeenCalledTimes(2));
  });

  it("are withdrawn, and say what did not work", async () => {
    const fetched = answers({ code: "alert_not_found", title: "Not found", detail: "it has ended" }, 404);
    const { user } = renderPage(fakeGateway(), { robots, alerts: [{ ...low, acknowledged: seen }] });
    await user.click(screen.getByRole("button", { name: "Show 1 more" }));
    await user.click(screen.getByRole("button", { name: "Withdraw: Low battery: /robot1" }));
    expect(await screen.findByText("It has ended")).toBeDefined();
    expect(fetched.mock.calls[0]?.[0].method).toBe("DELETE");
  });
});

describe("the list's view", () => {
  it("is what the address says, and the other way round", () => {
    const query = new URLSearchParams("q=robot&group=Hall+1&show=docked&sort=battery&order=desc&hide=place");
    const view = overviewView.read(query);
    expect(view).toEqual({
      text: "robot",
      group: "Hall 1",
      site: null,
      show: "docked",
      sort: "battery",
      descending: true,
      hidden: ["place"],
    });
    expect(overviewView.write(view).toString()).toBe(query.toString());
    expect(
      overviewView.write(overviewView.read(new URLSearchParams("show=what&sort=ever&order=ever"))).toString(),
    ).toBe("");
    expect(overviewView.read(new URLSearchParams("hide=")).hidden).toEqual([]);
    expect(overviewView.read(new URLSearchParams("hide=link,wheels,place")).hidden).toEqual([
      "place",
      "link",
    ]);
  });

  it("sorts by group, robots without one last", () => {
    const view = overviewView.read(new URLSearchParams({ sort: "groups" }));
    const grouped = [one, { ...ten, groups: ["Hall 2"] }, { ...two, groups: ["Hall 10"] }];
    expect(listed(grouped, view, new Map()).map(({ name }) => name)).toEqual([
      "/robot10",
      "/robot2",
      "/robot1",
    ]);
  });

  it("sorts by each column", () => {
    const orders = ["name", "place", "goal", "last", "link"].map((sort) => {
      const view = overviewView.read(new URLSearchParams({ sort }));
      return listed([ten, two, one], view, new Map()).map(({ name }) => name.slice(6));
    });
    expect(orders).toEqual([
      ["1", "2", "10"],
      ["1", "2", "10"],
      ["10", "2", "1"],
      ["1", "2", "10"],
      ["10", "1", "2"],
    ]);
  });
});

describe("the share of the robots that a gateway serves", () => {
  it("is named, with the gateways that serve the others", async () => {
    session.set({ ...session.state, share: ["/fleet_a/*"] });
    const gateway = { host: "hall", address: null, robots: ["/fleet_a/*"], this: true, id: "a" };
    const other = { ...gateway, address: "http://hall:8001", robots: ["/fleet_b/*"], this: false, id: "b" };
    vi.stubGlobal("fetch", async () => Response.json({ gateways: [gateway, other] }));
    renderPage(fakeGateway(), { robots });
    const link = await screen.findByRole("link", { name: "http://hall:8001" });
    expect(link.parentElement?.textContent).toBe(
      "This gateway serves /fleet_a/*. /fleet_b/*: http://hall:8001 on hall.",
    );
    session.set({ ...session.state, share: [] });
    vi.unstubAllGlobals();
  });
});
