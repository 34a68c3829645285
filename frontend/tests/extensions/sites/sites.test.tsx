import { notifications } from "@mantine/notifications";
import { act, screen, waitFor, within } from "@testing-library/react";
import type { UserEvent } from "@testing-library/user-event";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import "../../../src/goals/GoalsPage";
import "../../../src/pages/overview/RobotTable";
import "../../../src/pages/wall/WallPage";
import "../../../src/extensions/sites/PendingStops";
import "../../../src/extensions/sites/SiteStrip";
import "../../../src/extensions/sites/SitesOverviewPage";
import "../../../src/extensions/sites/SitesPage";
import { ownId, placeOf } from "../../../src/api/places";
import { ANYBODY, type SessionState, session } from "../../../src/api/session";
import { hubName } from "../../../src/extensions/sites/hub";
import type { Site } from "../../../src/extensions/sites/requests";
import { clockWords, countWords, refusalWords, urgentSites } from "../../../src/extensions/sites/sites";
import { goalPath, robotPath } from "../../../src/fleet/names";
import { linkOf } from "../../../src/fleet/words";
import { FleetScenes } from "../../../src/pages/map/scenes";
import { find } from "../../../src/search/items";
import { alert, emptyScene, goal, latched, robot } from "../../events";
import { descriptionOf, fakeGateway, renderPage } from "../../page";

const site = (name: string, change: Partial<Site> = {}): Site => ({
  name,
  state: "connected",
  changed_at: "2026-11-27T18:00:00Z",
  version: "0.1.0",
  machine: `${name}-box`,
  lag_ms: 300,
  round_trip_ms: 4.21,
  clock_offset_s: 0.01,
  behind: false,
  robots: 2,
  goals_running: 1,
  alerts: 0,
  stop: { latched: false, robots: [] },
  refused: {},
  detail: null,
  ...change,
});
const oslo = site("oslo", { state: "unreachable", lag_ms: 80_000, robots: 1, goals_running: 0 });
const of = (name: string, state: Site["state"] = "connected") =>
  Object.assign(robot(name, { default: false, simulated: false }), {
    site: name.split("/")[1],
    site_state: state,
  });
const robots = [of("/berlin/robot1"), of("/berlin/robot2"), of("/oslo", "unreachable")];

/** What the hub answers to requests, by method and path. */
const answers = new Map<string, unknown>();
const asked: string[] = [];

beforeEach(() => {
  session.set({ ...ANYBODY, hub: true } as SessionState);
  asked.length = 0;
  answers.clear();
  answers.set("GET /sites", { sites: [site("berlin"), oslo] });
  vi.stubGlobal("fetch", async (request: Request | string) => {
    if (typeof request === "string") return Response.json({ status: "ok" });
    const { pathname, search } = new URL(request.url);
    const what = `${request.method} ${pathname}`;
    asked.push(what + search);
    const answer = answers.get(what);
    if (answer instanceof Response) return answer.clone();
    if (request.method === "DELETE" && answer === undefined) return new Response(null, { status: 204 });
    return answer === undefined
      ? Response.json({ status: 404, code: "not_found", title: "Not found", detail: what }, { status: 404 })
      : Response.json(answer);
  });
});
afterEach(() => {
  vi.unstubAllGlobals();
  session.set(ANYBODY);
});

describe("a name of a hub", () => {
  it("has its site in front", () => {
    expect(placeOf("/berlin/robot1")).toEqual({ site: "berlin", prefix: "/sites/berlin", name: "/robot1" });
    expect(placeOf("/berlin/hall/r1/dock").name).toBe("/hall/r1/dock");
    expect(placeOf("/oslo").name).toBe("/");
    expect(ownId("berlin.a/b", "/berlin/robot1")).toBe("a/b");
  });

  it("leads to the page of its site", () => {
    expect(robotPath("/berlin/robot1")).toBe("/sites/berlin/ui/robot?robot=/robot1");
    expect(robotPath("/oslo")).toBe("/sites/oslo/ui/robot?robot=/");
    expect(goalPath("a", "/berlin/robot1/dock")).toBe("/sites/berlin/ui/goals/a");
    expect(goalPath("a", null)).toBe("/ui/goals/a");
  });

  it("is as it is at a gateway", () => {
    session.set(ANYBODY);
    expect(placeOf("/berlin/robot1")).toEqual({ site: null, prefix: "", name: "/berlin/robot1" });
    expect(robotPath("/berlin/robot1")).toBe("/ui/robot?robot=/berlin/robot1");
    expect(ownId("berlin.a", "/berlin")).toBe("berlin.a");
  });

  it("is that of the hub also where a site itself tells of it", () => {
    const scenes = new FleetScenes([], [], (robot) => hubName("berlin", robot));
    scenes.onEvent({ type: "scenes", time: "", scenes: { "/": emptyScene, "/r1": emptyScene } });
    expect(Object.keys(scenes.latest)).toEqual(["/berlin", "/berlin/r1"]);
  });
});

describe("the overview of a hub", () => {
  it("has the robots of all sites, each of which opens at its site", async () => {
    renderPage(fakeGateway(), { robots });
    const row = await screen.findByTestId("robot /berlin/robot1");
    expect(within(row).getByRole<HTMLAnchorElement>("link").getAttribute("href")).toBe(
      "/sites/berlin/ui/robot?robot=/robot1",
    );
    const sites = within(await screen.findByRole("navigation", { name: "Sites" }));
    expect(sites.getAllByRole("link").map(({ textContent }) => textContent)).toEqual([
      "osloUnreachable1 robot",
      "berlin2 robots, 1 goal",
    ]);
    expect(sites.getAllByRole<HTMLAnchorElement>("link")[1]?.getAttribute("href")).toBe("/sites/berlin/");
  });

  it("marks robots of a site that is not reached, and shows them as they were", async () => {
    expect(linkOf(robots[2] as (typeof robots)[0])).toBe("away");
    renderPage(fakeGateway(), { robots });
    const row = await screen.findByTestId("robot /oslo");
    expect(row.dataset.away).toBe("true");
    expect(row.textContent).toContain("Site unreachable");
    expect(row.textContent).toContain("Unknown");
  });

  it("is narrowed to a site", async () => {
    renderPage(fakeGateway(), { robots }, "/?site=oslo");
    expect(await screen.findByTestId("robot /oslo")).toBeDefined();
    expect(screen.queryByTestId("robot /berlin/robot1")).toBeNull();
    expect(screen.getByRole<HTMLSelectElement>("combobox", { name: "Site" }).value).toBe("oslo");
  });

  it("offers what the hub itself can do: stop", async () => {
    const { user } = renderPage(fakeGateway(), { robots });
    const row = await screen.findByTestId("robot /berlin/robot1");
    await user.click(within(row).getByRole("button", { name: "Commands for /berlin/robot1" }));
    const items = (await screen.findAllByRole("menuitem")).map(({ textContent }) => textContent);
    expect(items).toEqual(["Stop"]);
    const pages = within(screen.getByRole("navigation", { name: "Pages" })).getAllByRole("link");
    expect(pages.map(({ textContent }) => textContent)).toEqual([
      "Overview",
      "Sites",
      "Map",
      "Goals",
      "Statistics",
    ]);
    expect(
      find("dock", { robots, groups: [], actions: [], goals: [], pages: [], help: [], live: true }),
    ).toEqual([]);
  });

  it("says how the first site is connected", async () => {
    answers.set("GET /sites", { sites: [] });
    renderPage(fakeGateway(), { robots: [] });
    expect(await screen.findByText("No site yet")).toBeDefined();
    expect(screen.getByText(/^dock-gateway serve --nats .* --site berlin/)).toBeDefined();
  });

  it("leads from an alert to its goal", () => {
    const known = alert("berlin.goal_failed", { robot: "/berlin/robot1", goal_id: "g" });
    renderPage(fakeGateway(), { robots, alerts: [known] });
    expect(screen.getByRole("link", { name: "See the goal" }).getAttribute("href")).toBe(
      "/sites/berlin/ui/goals/g",
    );
  });
});

describe("a stop at a hub", () => {
  const stopped = { stopped: true, warning: null, code: null, detail: null, repeated: false };
  const missed = {
    ...stopped,
    stopped: false,
    code: "site_unreachable",
    detail: "the site oslo is not connected",
    repeated: true,
  };
  const press = async (user: UserEvent) => user.click(screen.getByRole("button", { name: "Stop" }));
  afterEach(() => act(() => notifications.clean()));

  it("is of every site, and names those that have confirmed it", async () => {
    answers.set("POST /stop", { sites: { berlin: stopped, oslo: stopped }, warning: null });
    const { user } = renderPage(fakeGateway(), { robots });
    await press(user);
    const notice = await screen.findByText("Stopped: berlin, oslo. Each site has confirmed it.");
    expect(notice).toBeDefined();
    expect(asked).toContain("POST /stop");
  });

  it("is not said to be done where a site was not reached", async () => {
    const problem = {
      code: "stop_incomplete",
      title: "Stop incomplete",
      detail: "",
      sites: { berlin: stopped, oslo: missed },
    };
    answers.set("POST /stop", Response.json(problem, { status: 504 }));
    const { user } = renderPage(fakeGateway(), { robots });
    await press(user);
    expect(await screen.findByText("Stop has NOT reached oslo")).toBeDefined();
    expect(
      screen.getByText(/^Stopped: berlin. Not reached: the site oslo is not connected. The hub repeats it/),
    );
  });

  it("was not delivered where the hub does not answer", async () => {
    const { user } = renderPage(fakeGateway(), { robots });
    await press(user);
    expect(await screen.findByText("Stop was NOT delivered to any robot")).toBeDefined();
  });

  it("stays on the page until it is confirmed or released", async () => {
    const pending = { robots: ["/oslo"], by: "Ada", stopped_at: "2026-11-27T18:00:00Z" };
    const stop = { latched: false, robots: [], pending };
    answers.set("GET /sites", { sites: [site("berlin"), { ...oslo, stop }] });
    answers.set("DELETE /stop", { sites: {} });
    const { user } = renderPage(fakeGateway(), { robots }, "/ui/sites");
    const banner = within(await screen.findByTestId("pending-stop"));
    expect(banner.getByRole("status").textContent).toMatch(/NOT reached oslo.oslo: stopped by Ada at/);
    await user.click(banner.getByRole("button", { name: "Release …" }));
    const question = await screen.findByRole("dialog", { name: "Release the stop?" });
    await user.click(within(question).getByRole("button", { name: "Release" }));
    await waitFor(() => expect(asked).toContain("DELETE /stop?robot=%2Foslo"));
  });

  it("is released at the hub", async () => {
    answers.set("DELETE /stop", { sites: { berlin: { released: true, code: null, detail: null } } });
    const held = [Object.assign(of("/berlin"), { stop: latched("Ada") }), ...robots];
    const { user } = renderPage(fakeGateway(), { robots: held });
    await user.click(screen.getByRole("button", { name: "Release …" }));
    const question = await screen.findByRole("dialog", { name: "Release the stop?" });
    await user.click(within(question).getByRole("button", { name: "Release" }));
    await waitFor(() => expect(asked).toContain("DELETE /stop?robot=%2Fberlin"));
  });
});

describe("the goals of a hub", () => {
  it("lead to their sites, and to no recordings", async () => {
    const ended = goal("g", { action_name: "/berlin/robot1/dock", status: "succeeded" });
    answers.set("GET /goals", { goals: [ended], next_cursor: null });
    renderPage(fakeGateway(), { robots }, "/ui/goals");
    await waitFor(() =>
      expect(within(screen.getByRole("table")).getByRole("link").getAttribute("href")).toBe(
        "/sites/berlin/ui/goals/g",
      ),
    );
    expect(asked.filter((each) => /recordings|tags|actions/.test(each))).toEqual([]);
  });
});

describe("the page of sites", () => {
  it("says how each is, and why it was refused", async () => {
    const hall = site("hall", {
      state: "refused",
      detail: "the gateway is 0.3.0 and the hub 0.1.0: they may be one minor release apart",
      refused: { version_refused: 3 },
    });
    const lisbon = site("lisbon", {
      behind: true,
      clock_offset_s: 3600,
      stop: { latched: true, robots: ["/lisbon", "/lisbon/r"] },
    });
    answers.set("GET /sites", { sites: [site("berlin"), hall, lisbon, oslo] });
    renderPage(fakeGateway(), { robots }, "/ui/sites");
    const row = async (name: string) => (await screen.findByTestId(`site ${name}`)).textContent;
    expect(await row("berlin")).toMatch(/berlin-boxConnectedsince .*2100.1.0now4.2 ms/);
    expect(await row("hall")).toMatch(/Refused.*The gateway is 0.3.0.*too far from the hub's \(3×\)/);
    expect(await row("lisbon")).toMatch(/Stopped.*still reads what it missed.*clock is 3600 s ahead/);
    expect(await row("oslo")).toMatch(/Unreachable.*as they were.*1 min 20 s ago–/);
  });

  it("forgets a site that is not connected, after a question", async () => {
    const { user } = renderPage(fakeGateway(), { robots }, "/ui/sites");
    const button = await screen.findByRole("button", { name: "Forget berlin …" });
    expect(button.ariaDisabled).toBe("true");
    expect(descriptionOf(button)).toMatch(/^It is connected/);
    await user.click(screen.getByRole("button", { name: "Forget oslo …" }));
    const question = await screen.findByRole("dialog", { name: "Forget oslo?" });
    await user.click(within(question).getByRole("button", { name: "Forget" }));
    await waitFor(() => expect(asked).toContain("DELETE /sites/oslo"));
  });
});

describe("sites in words", () => {
  it("counts, and says what is odd", () => {
    expect(countWords(site("a", { robots: 1, goals_running: 2, alerts: 1 }))).toBe(
      "1 robot, 2 goals, 1 alert",
    );
    expect(refusalWords(site("a", { refused: { malformed: 1, foreign_subject: 4 } }))).toEqual([
      "foreign subject (4×)",
      "a message could not be read (1×)",
    ]);
    expect(clockWords(site("a"))).toBeNull();
    expect(clockWords(site("a", { clock_offset_s: -3 }))).toBe("Its clock is 3 s behind the hub's");
  });

  it("has those first that need eyes", () => {
    const all = [
      site("b"),
      site("a10"),
      site("a2"),
      site("c", { alerts: 1 }),
      site("d", { stop: { latched: true, robots: ["/d"] } }),
      oslo,
    ];
    expect(urgentSites(all).map(({ name }) => name)).toEqual(["oslo", "d", "c", "a2", "a10", "b"]);
  });
});
