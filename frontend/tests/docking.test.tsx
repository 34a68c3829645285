import type { GatewayEvent } from "@dock-gateway/client";
import { act, screen, waitFor, within } from "@testing-library/react";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { whyNotSend } from "../src/docking/families";
import { at, goal, robot, server, simulator, undockServer } from "./events";
import { fakeGateway, renderPage } from "./page";

const button = (name: string) => screen.getByRole<HTMLButtonElement>("button", { name });
const asks = () => screen.getByRole<HTMLInputElement>("switch", { name: /Confirm before moving/ });

beforeEach(() => localStorage.clear());

describe("a robot that is about to move", () => {
  it("is asked about, and stands still where the answer is no", async () => {
    const gateway = fakeGateway();
    const { user } = renderPage(gateway);
    await user.click(button("Dock"));
    const question = await screen.findByRole("dialog", { name: "Dock the robot?" });
    expect(within(question).getByText(/the area is clear/)).toBeDefined();
    expect(document.activeElement?.textContent).toBe("Leave it where it is");
    await user.click(button("Leave it where it is"));
    await waitFor(() => expect(screen.queryByRole("dialog")).toBeNull());
    expect(gateway.dock).not.toHaveBeenCalled();
  });

  it("moves after a yes, and without a question once that is switched off in this browser", async () => {
    const gateway = fakeGateway();
    const { user } = renderPage(gateway);
    await user.click(button("Undock"));
    await user.click(
      within(await screen.findByRole("dialog", { name: "Undock the robot?" })).getByRole("button", {
        name: "Undock",
      }),
    );
    expect(gateway.undock).toHaveBeenCalledTimes(1);
    await user.click(asks());
    expect(localStorage.getItem("dock-gateway-ask-before-moving")).toBe("false");
    await user.click(button("Cancel"));
  });

  it("is not asked about where it is simulated", async () => {
    const gateway = fakeGateway();
    const { store, user } = renderPage(gateway);
    expect(asks().checked).toBe(true);
    act(() => store.onEvent({ type: "simulator", time: at(1), robot: "/", simulator }));
    await waitFor(() => expect([asks().checked, asks().disabled]).toEqual([false, true]));
    await user.click(button("Dock"));
    expect(gateway.dock).toHaveBeenCalledTimes(1);
  });

  it("cannot be sent any more where the question was open for too long, and that is said there", async () => {
    const gateway = fakeGateway();
    const { store, user } = renderPage(gateway);
    await user.click(button("Undock"));
    const question = await screen.findByRole("dialog");
    const gone = { ...undockServer, available: false, answering: false };
    act(() => store.onEvent({ type: "action_server", time: at(1), action_server: gone }));
    await within(question).findByText(/No server offers the action/);
    expect(within(question).getByRole<HTMLButtonElement>("button", { name: "Undock" }).disabled).toBe(true);
  });
});

describe("a robot with several docks", () => {
  const dock = (dock_id: string) => ({ dock_id, type: null, frame: "map", pose: null, tag_id: null });
  const docks = (names: string[], standard: string | null = null) =>
    fakeGateway({
      docks: vi.fn(async () => ({
        node: "/d",
        dock_database: null,
        default: standard,
        docks: names.map(dock),
      })),
    });

  it("drives to the default dock unless another one is chosen, and the question names it", async () => {
    const gateway = docks(["home", "lab"], "lab");
    const { user } = renderPage(gateway);
    const choice = await screen.findByRole<HTMLSelectElement>("combobox", { name: "Dock to" });
    expect([...choice.options].map(({ text }) => text)).toEqual(["lab (default)", "home"]);
    expect(choice.value).toBe("lab");
    await user.selectOptions(choice, "home");
    await user.click(button("Dock"));
    const question = await screen.findByRole("dialog");
    expect(within(question).getByText(/drives to the dock home/)).toBeDefined();
    await user.click(within(question).getByRole("button", { name: "Dock" }));
    expect(gateway.dock).toHaveBeenCalledWith(1, "home");
  });

  it.each([null, "elsewhere"])("calls none the default one where that is %s", async (standard) => {
    renderPage(docks(["home", "lab"], standard));
    const choice = await screen.findByRole<HTMLSelectElement>("combobox", { name: "Dock to" });
    expect([...choice.options].map(({ text }) => text)).toEqual(["home", "lab"]);
  });

  it.each([
    ["there is only one", docks(["home"])],
    [
      "they cannot be read",
      fakeGateway({ docks: vi.fn(async () => Promise.reject(new Error("no answer"))) }),
    ],
  ])("is not asked which one where %s", async (_, gateway) => {
    renderPage(gateway);
    await waitFor(() => expect(gateway.docks).toHaveBeenCalled());
    await screen.findByRole("button", { name: "Dock" });
    expect(screen.queryByRole("combobox", { name: "Dock to" })).toBeNull();
  });
});

describe("a docking server that is not ours", () => {
  const nav2 = { ...server, action_name: "/dock_robot", action_type: "nav2_msgs/action/DockRobot" };

  it("is named, and is not asked for a battery state", async () => {
    const gateway = fakeGateway();
    const { store, user } = renderPage(gateway, { docking: { dock: nav2, undock: undockServer } });
    expect(screen.getByTestId("docking-family").textContent).toBe("nav2");
    expect(screen.queryByText("Dock until the battery is")).toBeNull();
    act(() => store.onEvent({ type: "simulator", time: at(1), robot: "/", simulator }));
    await waitFor(() => expect(asks().checked).toBe(false));
    await user.click(button("Dock"));
    expect(gateway.dock).toHaveBeenCalledWith(null, undefined);
  });

  it("is what to start where it is gone", () => {
    const idle = { live: true, stopped: false, running: null, sending: false };
    const why = whyNotSend("dock", { ...idle, server: { ...nav2, available: false } });
    expect(why).toBe("No server offers the action /dock_robot. Start nav2's docking_server.");
  });
});

describe("a goal that ran when the page was opened", () => {
  it("has the stages that it was in before, out of its history", async () => {
    const ago = (seconds: number) => new Date(Date.now() - seconds * 1000).toISOString();
    const statuses = [
      { type: "status", time: ago(65), stage: "INITIAL_PERCEPTION" },
      { type: "status", time: ago(63), stage: "NAV_TO_STAGING_POSE" },
      { type: "status", time: ago(13), stage: "CONTROLLING" },
    ];
    const fetch = vi.fn(async (_: Request) =>
      Response.json({
        events: statuses,
        next_after: null,
        complete: true,
        node: "/dock_gateway",
        rules: [],
        missions: [],
      }),
    );
    vi.stubGlobal("fetch", fetch);
    renderPage(fakeGateway(), {
      goals: [goal("a", { stage: "CONTROLLING", created_at: ago(65), updated_at: ago(13) })],
    });
    const steps = () => within(screen.getByTestId("stages")).getAllByRole("listitem");
    await waitFor(() =>
      expect(steps().map((step) => step.textContent)).toEqual([
        expect.stringMatching(/^✓Perception: done2\.0 s$/),
        expect.stringMatching(/^✓Staging: done50 s$/),
        expect.stringMatching(/^3Controlling: now1\d s$/),
        expect.stringMatching(/^4Wait for charge: not yet$/),
      ]),
    );
    const urls = fetch.mock.calls.map(([request]) => request.url);
    expect(urls.filter((url) => url.endsWith("/goals/a/history?type=status&limit=2000"))).toHaveLength(1);
  });
});

describe("one robot of several", () => {
  const several = {
    type: "robots",
    time: at(0),
    robots: [robot("/", { default: true }), robot("/robot1", { default: false })],
    gone: [],
  } as unknown as GatewayEvent;

  it("has a Stop of its own", async () => {
    const gateway = fakeGateway();
    const { store, user } = renderPage(gateway, { robots: [robot("/robot1")] }, "/ui/robot?robot=/robot1");
    expect(screen.queryByRole("button", { name: "Stop /robot1" })).toBeNull();
    act(() => store.onEvent(several));
    await user.click(await screen.findByRole("button", { name: "Stop /robot1" }));
    expect(gateway.stop).toHaveBeenCalledTimes(1);
    expect(await screen.findByText("Zero velocity was sent. One goal is being canceled.")).toBeDefined();
  });

  it("has none where the header's does just that", async () => {
    const { store } = renderPage(fakeGateway(), {}, "/ui/robot");
    act(() => store.onEvent(several));
    expect(screen.queryByRole("button", { name: /Stop \// })).toBeNull();
  });
});

describe("a docking server in another namespace", () => {
  it("is offered with the lines to set", async () => {
    const settings = ['robots."/".dock_action = "/docking/dock_robot"'];
    const join = { detail: "If /docking/dock_robot docks /, set it.", settings };
    renderPage(fakeGateway(), { robots: [robot("/", { dock: null, undock: null, join })] });
    const hint = await screen.findByTestId("join");
    expect(within(hint).getByText(settings[0] ?? "")).toBeDefined();
    expect(within(hint).getByRole("button", { name: /^Copy/ })).toBeDefined();
  });

  it("is not mentioned otherwise", () => {
    renderPage(fakeGateway());
    expect(screen.queryByTestId("join")).toBeNull();
  });
});
