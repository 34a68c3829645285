import type { Alert, Robot } from "@dock-gateway/client";
import { act, cleanup, screen, within } from "@testing-library/react";
import { afterEach, beforeAll, beforeEach, describe, expect, it, vi } from "vitest";
import { isThere, linkOf } from "../src/fleet/words";
import { Tile } from "../src/pages/wall/Tile";
import {
  alert,
  at,
  battery,
  batteryDocument,
  goal,
  latched,
  released,
  robot,
  sceneEvent,
  server,
  undockGoal,
} from "./events";
import { fakeGateway, loadRobotTable, renderPage, renderWithin, robotServices } from "./page";

/** What a place says of a robot; undefined where it leaves something to others. */
interface Said {
  docked?: string | undefined;
  charge?: string | undefined;
  charging?: boolean | undefined;
  low?: boolean | undefined;
  stale?: boolean | undefined;
  link?: string | undefined;
  stopped?: boolean | undefined;
}

/** Numbers that look random, and are the same each time. */
function numbers(seed: number): () => number {
  let state = seed;
  return () => {
    state = (state * 1_664_525 + 1_013_904_223) % 2 ** 32;
    return state / 2 ** 32;
  };
}

const STATES = 24;
const next = numbers(20_261_130);

function oneOf<Value>(...values: Value[]): Value {
  return values[Math.floor(next() * values.length)] as Value;
}

/** A robot in a state that a gateway can tell. */
function anyRobot(name: string): Robot {
  const status = oneOf(0, 1, 2, 3, 4);
  const docked = oneOf(true, false, null);
  const percentage = oneOf(0.05, 0.195, 0.24, 0.245, 0.81, 1.015, null);
  const age_s = oneOf(10_000, 0, 0);
  const ended = { status: "succeeded", action_name: `${name}/dock` } as const;
  const action = (verb: string) =>
    oneOf(
      { ...server, action_name: `${name}/${verb}` },
      { ...server, action_name: `${name}/${verb}`, answering: false },
      { ...server, action_name: `${name}/${verb}`, available: false, answering: false },
    );
  return robot(name, {
    docked,
    charging: status === 0 ? oneOf(null, docked === true) : status === 1 || status === 4,
    battery: oneOf(
      batteryDocument(null),
      batteryDocument(
        { ...battery, percentage, power_supply_status: status },
        {
          received_at: new Date(Date.now() - 1000 * age_s).toISOString(),
          stale: age_s > 0,
          stale_after_s: 5000, // a slow machine makes no battery stale
        },
      ),
    ),
    stop: oneOf(released, released, { ...latched(oneOf("Ada", null)), robots: [name] }),
    dock: action("dock"),
    undock: action("undock"),
    last_goal: oneOf(null, goal("l", ended), undockGoal("l", { ...ended, action_name: `${name}/undock` })),
  });
}

const CHARGE = /(\d+ %|\d\.\d\d V)/;
const PLACES = { Docked: "docked", "Not docked": "not docked", Unknown: "unknown" } as const;

function chargeIn(text: string): string | undefined {
  return CHARGE.exec(text)?.[1];
}

function inRow(name: string): Said {
  const row = screen.getByTestId(`robot ${name}`);
  const cells = within(row).getAllByRole("cell");
  const [, place, level, now, , link] = cells.map(({ textContent }) => textContent ?? "");
  return {
    docked: PLACES[place as keyof typeof PLACES],
    charge: chargeIn(level ?? ""),
    charging: /Charging|full/.test(level ?? ""), // the bolt, or the word
    low: level?.includes("low"),
    stale: level?.includes("stale"),
    link,
    stopped: now?.includes("Stopped"),
  };
}

function inTile(name: string): Said {
  const text = screen.getByTestId(`tile ${name}`).textContent ?? "";
  const place = /(Not docked|Docked|Unknown)/.exec(text)?.[1];
  const stopped = text.includes("Stopped");
  return {
    docked: PLACES[place as keyof typeof PLACES],
    charge: chargeIn(text),
    charging: text.includes("stale") || text.includes("low") ? undefined : text.includes("charging"),
    low: text.includes("stale") ? undefined : text.includes("low"),
    stale: text.includes("stale"),
    link: stopped ? undefined : /(Idle|Silent|No [a-z ]+|Unreachable)$/.exec(text)?.[1],
    stopped,
  };
}

function onPage(): Said {
  const main = screen.getByRole("main").textContent ?? "";
  const card = within(screen.getByRole("region", { name: "Battery" }));
  const status = card.getByTestId("battery-status").textContent ?? "";
  const head = screen.getByRole("heading", { level: 1 }).parentElement?.textContent ?? "";
  const known = !status.includes("No battery state yet");
  const scene = screen.getByTestId("scene-words").textContent ?? "";
  const place = screen.queryByTestId("place")?.textContent ?? "Unknown";
  const inScene = /(Not docked|Docked)/.exec(scene)?.[1] ?? "Unknown";
  expect(inScene).toBe(place);
  return {
    docked: PLACES[place as keyof typeof PLACES],
    charge: known ? (card.queryByText(/^\d+ %$/) ?? card.getByText(/^\d\.\d\d V$/)).textContent : undefined,
    charging: known ? ["Charging", "Full"].includes(status) : false,
    low: document.querySelector("[data-charge]")?.getAttribute("data-charge") === "low",
    stale: known ? main.includes("Stale") : false,
    link: /(Silent|No docking server|Unreachable|No battery state)$/.exec(head)?.[1] ?? "Connected",
    stopped: screen.queryByTestId("stop-banner") !== null,
  };
}

/** Where two places both say something, it is the same. */
function expectAgreement(one: Said, other: Said, name: string): void {
  for (const [about, said] of Object.entries(one)) {
    const there = other[about as keyof Said];
    if (said !== undefined && there !== undefined) expect([name, about, there]).toEqual([name, about, said]);
  }
}

beforeAll(loadRobotTable);
beforeEach(() => {
  localStorage.clear();
  vi.stubGlobal("fetch", async () => Response.json({ rules: [] }));
});
afterEach(() => {
  vi.unstubAllGlobals();
});

describe("whatever the state of a robot", () => {
  it("its row, its tile on the wall and its page say the same", async () => {
    const robots = Array.from({ length: STATES }, (_, index) => anyRobot(`/r${index}`)).filter(isThere);
    renderPage(fakeGateway(), { robots });
    const rows = new Map(robots.map(({ name }) => [name, inRow(name)]));
    cleanup();

    const tiles = robots.map((each) => <Tile key={each.name} robot={each} attention={0} live />);
    renderWithin(robotServices(fakeGateway(), { robots }).fleet, <ul>{tiles}</ul>);
    for (const { name } of robots) {
      const tile = inTile(name);
      if (tile.link === "Idle") tile.link = "Connected";
      expectAgreement(rows.get(name) ?? {}, tile, name);
    }
    cleanup();

    for (const each of robots) {
      const { name, stop, dock, undock } = each;
      const docking = { dock: dock ?? server, undock: undock ?? server };
      const first = { robots: [each], battery: each.battery, docking, stop };
      const { store } = renderPage(fakeGateway(), first, `/ui/robot?robot=${name}`);
      act(() => store.onEvent({ ...sceneEvent(), robot: name }));
      await screen.findByText(/Robot at/);
      expectAgreement(rows.get(name) ?? {}, onPage(), name);
      cleanup();
    }
  });
});

describe("a robot whose battery is heard no more", () => {
  const lost = batteryDocument(battery, { stale: true });

  it("is not called connected, although its docking servers answer", () => {
    expect(linkOf(robot("/robot1"))).toBe("connected");
    expect(linkOf(robot("/robot1", { battery: lost }))).toBe("stale");
    expect(linkOf(robot("/robot1", { battery: batteryDocument(null) }))).toBe("connected");
    const frozen = { ...server, answering: false };
    expect(linkOf(robot("/robot1", { battery: lost, dock: frozen, undock: null }))).toBe("unreachable");
  });
});

describe("what stands out among the commands", () => {
  const variantOf = (name: string) => screen.getByRole("button", { name }).getAttribute("data-variant");

  it.each([
    { docked: true, stands: "Undock", other: "Dock" },
    { docked: false, stands: "Dock", other: "Undock" },
    { docked: null, stands: "Dock", other: "Undock" },
  ])("is $stands where docked is $docked", ({ docked, stands, other }) => {
    renderPage(fakeGateway(), { robots: [robot("/", { docked })] });
    expect([variantOf(stands), variantOf(other)]).toEqual(["filled", "light"]);
  });
});

describe("the last goal", () => {
  it("says what it came to, not where the robot is now", () => {
    const moved = robot("/", {
      docked: false,
      last_goal: goal("l", { status: "succeeded", finished_at: at(9) }),
    });
    renderPage(fakeGateway(), { robots: [moved], goals: [goal("l", { status: "succeeded" })] });
    expect(screen.getByTestId("place").textContent).toBe("Not docked");
    const text = screen.getByRole("main").textContent ?? "";
    expect(text).toContain("The robot reached the dock.");
    expect(text).not.toMatch(/is on the dock|On the dock/);
  });
});

describe("an alert about a low battery", () => {
  const at24 = robot("/robot1", { battery: batteryDocument(battery) });
  const low = alert("low", { detail: "The battery of /robot1 fell below 20%. This alert ends at 25%." });

  it("says what the battery is now, as the row does", async () => {
    const { store } = renderPage(fakeGateway(), { robots: [at24, robot("/robot2")], alerts: [low] });
    const item = () => within(screen.getByRole("region", { name: "Alerts" })).getByRole("listitem");
    expect(item().textContent).toContain(", 24 % now");
    expect(inRow("/robot1").charge).toBe("24 %");
    const later = { ...at24, battery: batteryDocument({ ...battery, percentage: 0.23 }, { stale: true }) };
    act(() => store.onEvent({ type: "robots", time: at(2), robots: [later], gone: [] }));
    expect(await screen.findByText(/, 23 % when last heard/)).toBeDefined();
    expect(inRow("/robot1").charge).toBe("23 %");
  });
});

describe("a stop of all robots", () => {
  const robots = ["/robot10", "/robot2", "/robot1"].map((name) =>
    robot(name, { stop: { ...latched("Ada"), robots: [name] } }),
  );
  const stops: Alert[] = robots.map(({ name }) =>
    alert(name, {
      kind: "stop_latched",
      severity: "critical",
      robot: name,
      title: "Stopped",
      detail: `Ada stopped ${name}: goals are refused.`,
    }),
  );
  const items = () => within(screen.getByRole("region", { name: "Alerts" })).getAllByRole("listitem");

  it("is one banner and one alert, with the robots in the order of the table", () => {
    renderPage(fakeGateway(), { robots, alerts: stops });
    const banner = screen.getByTestId("stop-banner").textContent;
    expect(banner).toMatch(/^All 3 robots stopped by Ada at .*\/robot1, \/robot2, \/robot10: /);
    expect(items().map(({ textContent }) => textContent)).toEqual([
      expect.stringMatching(/^Stopped: \/robot1, \/robot2, \/robot10Goals are refused/),
    ]);
    expect(screen.getByTestId("alert-count").textContent).toBe("1 alert, critical");
    expect(within(screen.getByRole("table")).getAllByRole("rowheader")[0]?.textContent).toMatch(/\/robot1N/);
  });

  it("is acknowledged as one", async () => {
    const asked: string[] = [];
    vi.stubGlobal("fetch", async (request: Request) => {
      if (request.method !== "PUT") return Response.json({ rules: [] });
      const id = decodeURIComponent(request.url.split("/").at(-2) ?? "");
      asked.push(id);
      const acknowledged = { by: "Ada", acknowledged_at: at(5) };
      return Response.json({ ...stops.find((each) => each.id === id), acknowledged });
    });
    const { user } = renderPage(fakeGateway(), { robots, alerts: stops });
    await user.click(screen.getByRole("button", { name: /^Acknowledge: Stopped/ }));
    await user.type(await screen.findByLabelText("Your name"), "Ada{Enter}");
    expect(await screen.findByText("1 acknowledged", { exact: false })).toBeDefined();
    expect(asked.sort()).toEqual(["/robot1", "/robot10", "/robot2"]);
  });

  it("is two alerts where they were stopped at different times", () => {
    const later = stops.map((each, index) => (index === 0 ? { ...each, started_at: at(60) } : each));
    renderPage(fakeGateway(), { robots, alerts: later });
    expect(items()).toHaveLength(2);
  });
});
