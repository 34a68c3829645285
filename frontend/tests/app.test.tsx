import { ClientError, type GatewayEvent, type LiveGoal } from "@dock-gateway/client";
import { notifications } from "@mantine/notifications";
import { onlineManager } from "@tanstack/react-query";
import { act, screen, waitFor, within } from "@testing-library/react";
import type { UserEvent } from "@testing-library/user-event";
import { afterEach, describe, expect, it, vi } from "vitest";
import {
  battery,
  batteryDocument,
  batteryEvent,
  feedback,
  goal,
  idlePublisher,
  robot,
  server,
  status,
  stopReport,
  undockServer,
} from "./events";
import { descriptionOf, fakeGateway, isDisabled, renderPage } from "./page";

const button = (name: string) => screen.getByRole<HTMLButtonElement>("button", { name });
/** Presses Dock or Undock, and says yes. */
const move = async (user: UserEvent, name: "Dock" | "Undock") => {
  await user.click(button(name));
  const question = await screen.findByRole("dialog", { name: `${name} the robot?` });
  await user.click(within(question).getByRole("button", { name }));
};
const now = () => new Date().toISOString();
const running = goal("a", { created_at: now(), updated_at: now(), feedback_count: 3 });

afterEach(() => act(() => notifications.clean()));

describe("connection", () => {
  it("is said in the header, and below that what is shown is not live", async () => {
    const { store } = renderPage(fakeGateway());
    expect(screen.getByTestId("connection").textContent).toBe("live");
    act(() => store.onConnection({ kind: "closed" }));
    expect(screen.getByTestId("connection").textContent).toBe("reconnecting");
    expect(screen.getByText("Reconnecting to the gateway")).toBeDefined();
    expect(screen.getAllByText("Not live").length).toBeGreaterThan(0);
  });

  it("lost: commands are disabled and say why, Stop is not", () => {
    const { store } = renderPage(fakeGateway(), { goals: [running] });
    act(() => store.onConnection({ kind: "closed" }));
    for (const name of ["Dock", "Undock", "Cancel"]) {
      expect(isDisabled(name), name).toBe(true);
      expect(descriptionOf(button(name)), name).toBe("The gateway is not connected.");
    }
    expect(button("Stop").disabled).toBe(false);
  });

  it("lost: what developers do is disabled as well", async () => {
    const { store } = renderPage(fakeGateway(), { goals: [running] }, "/?tab=developer");
    await screen.findByText("Publish once");
    act(() => store.onConnection({ kind: "closed" }));
    for (const name of ["Publish once", "Publish repeatedly", "Stop publishing"]) {
      expect(isDisabled(name), name).toBe(true);
      expect(descriptionOf(button(name)), name).toMatch(/Publishing needs the gateway/);
    }
  });
});

describe("Stop", () => {
  it("works by click, again while one is under way, and by keyboard from a text field", async () => {
    const gateway = fakeGateway({ stop: vi.fn(() => new Promise<never>(() => {})) });
    const { user } = renderPage(gateway, undefined, "/ui/robot?tab=developer");
    await user.click(button("Stop"));
    await user.click(button("Stop"));
    await user.click(await screen.findByLabelText("Voltage (V)"));
    await user.keyboard("{Control>}{Shift>}X{/Shift}{/Control}");
    expect(gateway.stop).toHaveBeenCalledTimes(3);
  });

  it("says what it did", async () => {
    const { user } = renderPage(fakeGateway());
    await user.click(button("Stop"));
    expect(await screen.findByText("Zero velocity was sent. One goal is being canceled.")).toBeDefined();
  });

  it("says loudly where it did not get through, and where a goal was not canceled", async () => {
    const error = new ClientError("gateway_unreachable", "The gateway cannot be reached", "No answer.");
    const stop = vi.fn().mockRejectedValueOnce(error);
    const failure = { action_name: "/dock", robot: null, code: "action_server_timeout", detail: "no answer" };
    stop.mockResolvedValueOnce(stopReport({ failed: [failure] }));
    const { user } = renderPage(fakeGateway({ stop }));
    await user.click(button("Stop"));
    expect(await screen.findByText("Stop was NOT delivered to any robot")).toBeDefined();
    await user.click(button("Stop"));
    expect(await screen.findByText(/not every goal is canceled/)).toBeDefined();
  });

  it("is sent at once while the browser thinks that it is offline, and not once more later", async () => {
    const stop = vi.fn(async () => stopReport());
    const { user } = renderPage(fakeGateway({ stop }));
    act(() => onlineManager.setOnline(false));
    await user.click(button("Stop"));
    const sentOffline = stop.mock.calls.length;
    await act(async () => onlineManager.setOnline(true));
    expect([sentOffline, stop.mock.calls.length]).toEqual([1, 1]);
  });
});

describe("docking", () => {
  it("sends a goal and shows it", async () => {
    const gateway = fakeGateway();
    const { user } = renderPage(gateway);
    expect(isDisabled("Cancel")).toBe(true);
    await user.click(screen.getByText("Full", { selector: "label *" }));
    await move(user, "Dock");
    expect(gateway.dock).toHaveBeenCalledWith(4, undefined);
    expect((await screen.findByTestId("goal-status")).textContent).toBe("accepted");
  });

  it("undocks, and cancels that where it runs", async () => {
    const gateway = fakeGateway();
    const { user } = renderPage(gateway);
    await waitFor(() => expect(isDisabled("Undock")).toBe(false));
    await move(user, "Undock");
    expect(gateway.undock).toHaveBeenCalledTimes(1);
    expect(await screen.findByText("Running goal: Undock")).toBeDefined();
    await user.click(button("Cancel"));
    expect(gateway.cancel).toHaveBeenCalledWith("undocked");
  });

  it("does not undock where nobody offers that, and says so", () => {
    renderPage(fakeGateway(), {
      docking: { dock: server, undock: { ...undockServer, available: false, answering: false } },
    });
    expect(isDisabled("Dock")).toBe(false);
    expect(isDisabled("Undock")).toBe(true);
    expect(descriptionOf(button("Dock"))).toBe("");
    expect(descriptionOf(button("Undock"))).toMatch(
      /^No server offers the action \/disconnect_from_charging_dock/,
    );
  });

  it("shows the stages and the retries of a goal, and what to do about its end", async () => {
    const { store } = renderPage(fakeGateway(), { goals: [{ ...running, stage: "CONTROLLING" }] });
    const time = new Date(Date.now() + 1000).toISOString();
    const change = { created_at: running.created_at, updated_at: time, stage: "WAIT_FOR_CHARGE", retries: 2 };
    act(() => store.onEvent(status("a", change)));
    const stages = await screen.findByTestId("stages");
    await waitFor(() =>
      expect(within(stages).getByText("Wait for charge").closest("li")?.getAttribute("aria-current")).toBe(
        "step",
      ),
    );
    expect(screen.getByTestId("retries").textContent).toBe("2 retries");
    const error = { code: "failed_to_charge", detail: "contact without charge" };
    act(() => store.onEvent(status("a", { ...change, status: "aborted", error, finished_at: time })));
    expect(await screen.findByText(/look at the dock's power/)).toBeDefined();
    expect(screen.getByText("Code: failed_to_charge")).toBeDefined();
  });

  it("cancels the goal that runs, and does not dock meanwhile", async () => {
    const gateway = fakeGateway();
    const { user } = renderPage(gateway, { goals: [running] });
    expect(isDisabled("Dock")).toBe(true);
    expect(descriptionOf(button("Dock"))).toBe("A goal is running. Cancel it first.");
    await user.click(button("Dock"));
    expect(gateway.dock).not.toHaveBeenCalled();
    await user.click(button("Cancel"));
    expect(gateway.cancel).toHaveBeenCalledWith("a");
  });

  it("says why a goal was rejected and what to do", async () => {
    const error = new ClientError("dock_busy", "The dock is busy with another goal", "goal 7 is running");
    const { user } = renderPage(fakeGateway({ dock: vi.fn().mockRejectedValue(error) }));
    await move(user, "Dock");
    const alert = await screen.findByRole("alert");
    expect(alert.textContent).toMatch(/Dock did not work: the dock is busy/);
    expect(alert.textContent).toMatch(/Goal 7 is running/);
    expect(alert.textContent).toMatch(/cancel it and press Dock again/);
    await user.click(button("Dismiss the error"));
    expect(screen.queryByRole("alert")).toBeNull();
  });

  it("names the action server that is not there", () => {
    renderPage(fakeGateway(), {
      docking: { dock: { ...server, available: false, answering: false }, undock: undockServer },
    });
    expect(screen.getByTestId("action-server").textContent).toBe("action server not there");
    expect(isDisabled("Dock")).toBe(true);
    expect(descriptionOf(button("Dock"))).toMatch(/^No server offers the action \/dock/);
  });

  it("warns where the action server is silent, and explains a stall and a loss", () => {
    renderPage(fakeGateway(), {
      docking: { dock: { ...server, answering: false }, undock: undockServer },
      goals: [{ ...running, status: "lost", error: { code: "action_server_lost", detail: "it left" } }],
    });
    expect(screen.getByText(/not responding: a goal may time out/)).toBeDefined();
    expect(screen.getByText(/it left/i, { selector: "[role=alert] *" })).toBeDefined();
    expect(screen.getByText(/Check where the robot is/)).toBeDefined();
  });
});

describe("from a terminal", () => {
  it("cancels the goal that runs, not a newer one that was rejected", async () => {
    const rejected = goal("b", { status: "rejected", created_at: new Date(Date.now() + 1000).toISOString() });
    renderPage(fakeGateway(), { goals: [running, rejected] }, "/?tab=developer");
    expect(await screen.findByText(/^curl .*\/goals\/a\/cancel$/)).toBeDefined();
  });
});

describe("goals of other actions", () => {
  it("do not disturb the page", async () => {
    const fibonacci = { action_name: "/fibonacci", feedback: { partial_sequence: [0, 1, 1] } };
    const { store } = renderPage(fakeGateway(), {
      goals: [{ ...running, ...fibonacci } as unknown as LiveGoal],
    });
    act(() => {
      store.onEvent(status("f", { action_name: "/fibonacci" }));
      store.onEvent({ ...feedback("f"), ...fibonacci } as unknown as GatewayEvent);
      store.onEvent(batteryEvent());
    });
    expect(await screen.findByText("24 %")).toBeDefined();
    expect(screen.getByText("No goal yet")).toBeDefined();
    expect(isDisabled("Dock")).toBe(false);
    expect(isDisabled("Cancel")).toBe(true);
  });
});

function hearBattery(store: ReturnType<typeof renderPage>["store"]) {
  const time = new Date().toISOString();
  act(() =>
    store.onEvent({ ...batteryEvent(), time, battery: batteryDocument(battery, { received_at: time }) }),
  );
}

describe("battery", () => {
  it("teaches what to do where there is no state", () => {
    renderPage(fakeGateway());
    expect(screen.getByTestId("battery-status").textContent).toMatch(/No battery state yet/);
  });

  it("is said in words, and stale in plain sight", () => {
    const received_at = new Date(Date.now() - 9000).toISOString();
    renderPage(fakeGateway(), {
      battery: {
        state: { ...battery, current: -1.5 },
        percentage: 0.24,
        implausible: [],
        stale: true,
        stale_after_s: 4.5,
        low_below: 0.2,
        received_at,
      },
    });
    expect(screen.getByTestId("battery-status").textContent).toBe("Not charging");
    expect(screen.getByText("24 %")).toBeDefined();
    expect(screen.getByText("−1.50 A")).toBeDefined();
    expect(screen.getAllByText("Stale").length).toBeGreaterThan(0);
    expect(screen.getByText(/no battery message for more than 4.5 s/)).toBeDefined();
  });

  it("says what of it cannot be right, and does not use it", async () => {
    const { store } = renderPage(fakeGateway(), {}, "/ui/robot");
    const implausible = [{ field: "percentage", value: 12, expected: "0 to 1" }];
    const sent = batteryDocument({ ...battery, percentage: 12 }, { percentage: null, implausible });
    act(() => store.onEvent({ ...batteryEvent(), battery: sent }));
    expect(await screen.findByText(/percentage is 12, but should be 0 to 1/)).toBeDefined();
    const card = screen.getByRole("region", { name: "Battery" });
    expect(card.textContent).not.toMatch(/%/);
    expect(within(card).getByText("not measured")).toBeDefined();
  });

  it("says of its card and of its plots the same: stale, no data, not live", async () => {
    const received_at = new Date(Date.now() - 9000).toISOString();
    const old = {
      state: battery,
      percentage: 0.24,
      implausible: [],
      stale: true,
      stale_after_s: 4.5,
      low_below: 0.2,
      received_at,
    };
    const { store } = renderPage(fakeGateway(), { battery: old }, "/ui/robot");
    const badge = (card: string) =>
      within(screen.getByRole("region", { name: card })).queryByText(/^(Live|Stale|No data|Not live)$/)
        ?.textContent;
    const badges = () => ["Battery", "Battery over time"].map(badge);
    await waitFor(() => expect(badges()).toEqual(["Stale", "Stale"]));
    hearBattery(store);
    await waitFor(() => expect(badges()).toEqual(["Live", "Live"]));
    act(() => store.onConnection({ kind: "closed" }));
    await waitFor(() => expect(badges()).toEqual(["Not live", "Not live"]));
    expect(badge("Map")).toBe("Not live");
  });

  it("says what is no longer measured", async () => {
    const measured = { ...battery, current: -1.5 };
    const received_at = new Date().toISOString();
    const first = {
      state: measured,
      percentage: 0.24,
      implausible: [],
      stale: false,
      stale_after_s: 5,
      low_below: 0.2,
      received_at,
    };
    const { store } = renderPage(fakeGateway(), { battery: first }, "/ui/robot");
    expect(screen.getByText("−1.50 A")).toBeDefined();
    hearBattery(store);
    expect(await screen.findByText("no longer measured")).toBeDefined();
  });

  it("is stale when the gateway says so, not before", () => {
    const received_at = new Date(Date.now() - 9000).toISOString();
    renderPage(fakeGateway(), {
      battery: {
        state: battery,
        percentage: 0.24,
        implausible: [],
        stale: false,
        stale_after_s: 30,
        low_below: 0.2,
        received_at,
      },
    });
    expect(screen.queryByText("Stale")).toBeNull();
  });
});

describe("publishing", () => {
  it("publishes a preset once, and the other one repeatedly", async () => {
    const gateway = fakeGateway();
    const { user } = renderPage(gateway, {}, "/?tab=developer");
    await user.click(await screen.findByRole("button", { name: "Publish once" }));
    expect(gateway.publishOnce).toHaveBeenCalledWith({
      voltage: 2.16,
      percentage: 0.24,
      power_supply_status: 3,
    });
    expect(await screen.findByText(/Published once: 24 %, 2.16 V, not charging/)).toBeDefined();
    await user.click(button("On the dock, charging"));
    await user.click(button("Publish repeatedly"));
    expect(gateway.publishRepeatedly).toHaveBeenCalledWith(
      { voltage: 2.16, percentage: 0.24, power_supply_status: 1 },
      1,
    );
  });

  it("shows what is published, and stops it", async () => {
    const gateway = fakeGateway();
    const battery_publisher = {
      active: true,
      state: battery,
      rate_hz: 2,
      published_count: 17,
      started_at: now(),
    };
    const { user } = renderPage(gateway, { battery_publisher }, "/?tab=developer");
    expect((await screen.findByTestId("publisher-status")).textContent).toMatch(
      /24 %, 2.16 V, not charging at 2 Hz: 17 messages/,
    );
    await user.click(button("Stop publishing"));
    expect(gateway.stopPublishing).toHaveBeenCalledTimes(1);
  });

  it("warns where someone else publishes, by name, and not of the gateway itself", async () => {
    const topic = (...nodes: string[]) => ({
      name: "/battery_status",
      types: [],
      publishers: nodes.map((node) => ({ node })),
      subscribers: [],
      hidden: false,
    });
    const fetch = vi.fn(async (request: Request) =>
      Response.json(
        request.url.endsWith("/healthz")
          ? { node: "/dock_gateway" }
          : request.url.endsWith("/graph/topics/battery_status")
            ? topic("/dock_gateway", "/driver")
            : request.url.endsWith("/automation/rules")
              ? { rules: [] }
              : { missions: [] },
      ),
    );
    vi.stubGlobal("fetch", fetch);
    const { store } = renderPage(fakeGateway(), { battery_publisher: idlePublisher }, "/?tab=developer");
    act(() =>
      store.onEvent({
        type: "robots",
        time: now(),
        robots: [robot("/")],
        gone: [],
      } as unknown as GatewayEvent),
    );
    const warning = await screen.findByTestId("other-publishers");
    expect(warning.textContent).toMatch(/^\/driver publishes this battery/);
  });

  it("takes a value for each cell, of which some are not measured, and refuses what is no number", async () => {
    const gateway = fakeGateway();
    const { user } = renderPage(gateway, {}, "/?tab=developer");
    await user.click(await screen.findByRole("button", { name: "More fields" }));
    const cells = within(await screen.findByRole("group", { name: "Cell voltages (V)" }));
    await user.click(cells.getByRole("button", { name: "Add a cell" }));
    await user.type(cells.getByLabelText("Cell voltages (V), cell 1"), "3.9");
    await user.click(cells.getByRole("button", { name: "Add a cell" }));
    await user.clear(cells.getByLabelText("Cell voltages (V), cell 2"));
    await user.click(button("Publish once"));
    expect(gateway.publishOnce).toHaveBeenCalledWith(expect.objectContaining({ cell_voltage: [3.9, null] }));
    await user.type(cells.getByLabelText("Cell voltages (V), cell 2"), "-");
    expect(screen.getByText("Not a number")).toBeDefined();
    expect(isDisabled("Publish once")).toBe(true);
    expect(descriptionOf(button("Publish once"))).toBe("A field is not valid.");
  });
});

describe("recent goals", () => {
  it("show where a goal came from and lead to its page", async () => {
    const ended = goal("b", {
      origin: "external",
      status: "aborted",
      error: { code: "battery_lost", detail: "no battery for 60 s" },
      finished_at: now(),
    });
    renderPage(fakeGateway(), { goals: [ended] });
    const row = within(screen.getByRole("table")).getAllByRole("row")[1];
    if (!row) throw new Error("no row");
    expect(row.textContent).toMatch(/aborted.*external.*Battery data stopped/);
    expect(within(row).getByRole("link").getAttribute("href")).toBe("/ui/goals/b");
  });

  it("are ten at first; the list of all goals is elsewhere", async () => {
    const many = Array.from({ length: 12 }, (_, index) => goal(`g${index}`, { status: "succeeded" }));
    const { user } = renderPage(fakeGateway(), { goals: many });
    const rows = () => within(screen.getByRole("table")).getAllByRole("row").length - 1;
    expect(rows()).toBe(10);
    await user.click(button("Show 2 more"));
    expect(rows()).toBe(12);
    expect(screen.getByRole("link", { name: "All goals" }).getAttribute("href")).toBe(
      "/ui/goals?action=%2Fdock&action=%2Fdisconnect_from_charging_dock",
    );
  });
});
