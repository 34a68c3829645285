import { act, screen, waitFor, within } from "@testing-library/react";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { gridFor } from "../src/pages/wall/Tile";
import { newBuild, PAGE_MS } from "../src/pages/wall/WallPage";
import { alert, at, goal, latched, robot } from "./events";
import { fakeGateway, pressEscape, renderPage } from "./page";

beforeEach(() => {
  localStorage.clear();
  vi.stubGlobal("fetch", async () => Response.json({}));
});

const one = robot("/robot1", { display_name: "Left forklift", docked: true, groups: ["Hall 1"] });
const two = robot("/robot2", { goals: [goal("g", { action_name: "/robot2/dock", stage: "CONTROLLING" })] });
const three = robot("/robot3", { stop: latched("Ada") });
const dead = robot("/dead", { dock: null, undock: null, battery: { ...one.battery, stale: true } });
const robots = [one, two, three, dead];

const tiles = async () => (await screen.findAllByTestId(/^tile /)).map(({ textContent }) => textContent);

describe("the grid of a wall", () => {
  it("has tiles as large as can be, and pages where they would be too small", () => {
    expect(gridFor(1, 1920, 900)).toEqual({ columns: 1, rows: 1, pages: 1 });
    expect(gridFor(4, 1920, 900)).toEqual({ columns: 2, rows: 2, pages: 1 });
    expect(gridFor(30, 1920, 900).pages).toBe(1);
    const many = gridFor(300, 1920, 900);
    expect(many.pages).toBeGreaterThan(1);
    expect(many.columns * many.rows * many.pages).toBeGreaterThanOrEqual(300);
    expect(1920 / many.columns).toBeGreaterThanOrEqual(220);
    expect(900 / many.rows).toBeGreaterThanOrEqual(120);
    expect(gridFor(0, 0, 0)).toEqual({ columns: 1, rows: 1, pages: 1 });
  });
});

describe("the wall", () => {
  it("has a tile for each robot, by name, and words for what is wrong", async () => {
    renderPage(fakeGateway(), { robots, alerts: [alert("a", { robot: "/robot1" })] }, "/ui/wall");
    await tiles();
    expect(screen.getByText("Low battery: Left forklift")).toBeDefined();
    expect(screen.getByText("/robot3 stopped by Ada")).toBeDefined();
    expect(screen.queryByRole("button", { name: "Stop" })).toBeNull();
  });

  it("pages through by itself", async () => {
    vi.useFakeTimers({ toFake: ["setInterval", "clearInterval"] });
    renderPage(fakeGateway(), { robots }, "/ui/wall");
    // jsdom has no sizes, so that there is one robot on each page.
    expect(await tiles()).toEqual([expect.stringMatching("^/dead.*Unreachable")]);
    expect(screen.getByText("4, page 1 of 4")).toBeDefined();
    act(() => void vi.advanceTimersByTime(PAGE_MS));
    expect(await tiles()).toEqual([expect.stringMatching("^/robot2.*Dock: Controlling")]);
    act(() => void vi.advanceTimersByTime(3 * PAGE_MS));
    expect(await tiles()).toEqual([expect.stringMatching("^/dead")]);
  });

  it("is narrowed to a group, and Escape leads back to it", async () => {
    renderPage(fakeGateway(), { robots }, "/ui/wall?group=Hall+1");
    expect(await tiles()).toEqual([expect.stringMatching("^Left forklift.*Docked.*24 %.*Idle")]);
    expect(screen.getByRole("heading", { level: 1 }).textContent).toBe("Hall 11");
    pressEscape(1e8);
    expect(await screen.findByRole("table", { name: "Robots" })).toBeDefined();
    expect(screen.getByLabelText("Group")).toHaveProperty("value", "Hall 1");
  });

  it("stops every robot by Escape twice, although the first leads away", async () => {
    const gateway = fakeGateway();
    renderPage(gateway, { robots }, "/ui/wall");
    await tiles();
    pressEscape(1e9);
    expect(gateway.stop).not.toHaveBeenCalled();
    await screen.findByRole("table", { name: "Robots" });
    pressEscape(1e9 + 500);
    await waitFor(() => expect(gateway.stop).toHaveBeenCalledTimes(1));
  });

  it("says what is not live, since when", async () => {
    const { store } = renderPage(fakeGateway(), { robots }, "/ui/wall");
    await tiles();
    act(() => store.onConnection({ kind: "closed" }));
    const status = within(screen.getByRole("status"));
    expect(await status.findByText(/^Reconnecting to the gateway: as of/)).toBeDefined();
    act(() => store.onEvent({ type: "robots", time: at(1), robots: [], gone: ["/dead"] }));
  });

  it("is loaded again where the gateway has another build", async () => {
    const script = document.createElement("script");
    script.type = "module";
    script.setAttribute("src", "/assets/index-old.js");
    document.head.append(script);
    const answer = (text: string, status = 200) =>
      vi.stubGlobal("fetch", async () => new Response(text, { status }));
    answer('<script type="module" crossorigin src="/assets/index-old.js"></script>');
    expect(await newBuild()).toBeNull();
    answer('<script type="module" crossorigin src="/assets/index-new.js"></script>');
    expect(await newBuild()).toBe("/assets/index-new.js");
    answer("Bad gateway", 502);
    expect(await newBuild()).toBeNull();
    script.remove();
  });
});
