import { ClientError } from "@dock-gateway/client";
import { notifications } from "@mantine/notifications";
import { act, fireEvent, screen, waitFor, within } from "@testing-library/react";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { ownName, setOwnName } from "../src/access/who";
import { Naming } from "../src/fleet/names";
import { DoubleEscape, TWICE_WITHIN_MS } from "../src/stop/keys";
import { showStopped } from "../src/stop/notices";
import { at, latched, released, robot, snapshot, stopReport } from "./events";
import { descriptionOf, fakeGateway, isDisabled, renderPage } from "./page";

const button = (name: string) => screen.getByRole<HTMLButtonElement>("button", { name });
const banner = () => screen.queryByTestId("stop-banner");

beforeEach(() => localStorage.clear());
afterEach(() => act(() => notifications.clean()));

describe("a latched stop", () => {
  it("is a banner that says since when and by whom, and holds back Dock and Undock with the reason", () => {
    const { store } = renderPage(fakeGateway());
    expect(banner()).toBeNull();
    act(() =>
      store.onEvent({
        type: "stop",
        id: null,
        time: new Date().toISOString(),
        robot: "/",
        stop: latched("Ada"),
      }),
    );
    return waitFor(() => {
      expect(banner()?.textContent).toMatch(/^Robot stopped by Ada at \d/);
      expect([isDisabled("Dock"), isDisabled("Undock")]).toEqual([true, true]);
      expect(descriptionOf(button("Dock"))).toBe("The robot is stopped. Release the stop first.");
    });
  });

  it("is there from the snapshot on, also where nobody knows who it was", () => {
    renderPage(fakeGateway(), { stop: latched(null) });
    expect(banner()?.textContent).toMatch(/^Robot stopped at/);
  });

  it("names the robots below that are held", () => {
    renderPage(fakeGateway(), { stop: { ...latched("Ada"), robots: ["/", "/robot1"] } });
    expect(banner()?.textContent).toMatch(/^Robot, \/robot1 stopped by Ada/);
  });

  it("is released after a confirmation, and only then", async () => {
    const gateway = fakeGateway();
    const { store, user } = renderPage(gateway, { stop: latched("Ada") });
    await user.click(button("Release …"));
    await screen.findByRole("dialog", { name: "Release the stop?" });
    await user.click(button("Keep it stopped"));
    expect(gateway.release).not.toHaveBeenCalled();
    await user.click(button("Release …"));
    await user.click(await screen.findByRole("button", { name: "Release" }));
    expect(gateway.release).toHaveBeenCalledTimes(1);
    await waitFor(() => expect(banner()).toBeNull());
    act(() => store.onEvent({ type: "stop", id: null, time: at(9), robot: "/", stop: released }));
    await waitFor(() => expect(isDisabled("Dock")).toBe(false));
  });

  it("stays, and says why, where the release did not work", async () => {
    const error = new ClientError("ros_unavailable", "The gateway has lost ROS", "the thread ended");
    const gateway = fakeGateway({ release: vi.fn().mockRejectedValue(error) });
    const { user } = renderPage(gateway, { stop: latched("Ada") });
    await user.click(button("Release …"));
    await user.click(await screen.findByRole("button", { name: "Release" }));
    expect(await screen.findByText(/Release did not work/)).toBeDefined();
    expect(banner()).not.toBeNull();
  });

  it("is shown as soon as the gateway has answered, before the stream tells", async () => {
    const { user } = renderPage(fakeGateway());
    await user.click(button("Stop"));
    await waitFor(() => expect(banner()?.textContent).toMatch(/by the dashboard/));
  });

  it("can be brought about, but not released, while the stream is down", async () => {
    const { store, user } = renderPage(fakeGateway());
    act(() => store.onConnection({ kind: "closed" }));
    await user.click(button("Stop"));
    await waitFor(() => expect(banner()).not.toBeNull());
    expect(isDisabled("Release …")).toBe(true);
  });
});

describe("a warning of the gateway", () => {
  const warning = {
    type: "about:blank",
    title: "Stop not persisted",
    status: 503,
    code: "stop_not_persisted",
    detail: "No space left on device",
    errors: null,
    goal_id: null,
    running_goal_id: null,
    retry_after: null,
    limit: null,
    use: null,
    role: null,
    robots: null,
    docks: null,
    settings: null,
    gateway: null,
    robot: null,
    since_at: null,
  };

  it("is shown with the stop that it is about, until it is dismissed", async () => {
    const stop = vi.fn(async () => stopReport({ warning }));
    const { user } = renderPage(fakeGateway({ stop }));
    await user.click(button("Stop"));
    expect(await screen.findByText("Stopped, with a warning")).toBeDefined();
    expect(screen.getByText(/No space left on device \(stop_not_persisted\)/)).toBeDefined();
  });

  it("says which other gateways stop their robots, too", async () => {
    const others = [{ host: "hall", address: "http://hall:8001", robots: ["/fleet_b/*"] }];
    const stop = vi.fn(async () => stopReport({ others }));
    const { user } = renderPage(fakeGateway({ stop }));
    await user.click(button("Stop"));
    expect(
      await screen.findByText(/Other gateways stop their own robots: http:\/\/hall:8001\./),
    ).toBeDefined();
  });

  it("is shown beside a robot that was not reached", async () => {
    const failure = { action_name: null, robot: "/robot1", code: "publish_failed", detail: "no zero" };
    const stop = vi.fn(async () => stopReport({ warning, failed: [failure] }));
    const { user } = renderPage(fakeGateway({ stop }));
    await user.click(button("Stop"));
    expect(await screen.findByText("Stop did not reach every robot")).toBeDefined();
    expect(screen.getByText(/\/robot1: no zero .*emergency stop.*No space left on device/)).toBeDefined();
  });

  it("stays on the banner for as long as the stop is not stored", async () => {
    const { store } = renderPage(fakeGateway(), { stop: { ...latched("Ada"), persisted: false } });
    expect(banner()?.textContent).toMatch(/is not stored: a restart of the gateway would lose it/);
    act(() => store.onEvent({ type: "stop", id: null, time: at(1), robot: "/", stop: latched("Ada") }));
    await waitFor(() => expect(banner()?.textContent).not.toMatch(/is not stored/));
  });
});

describe("the stops of several robots", () => {
  const stoppedBy = (by: string, ...robots: string[]) => ({ ...latched(by), robots });
  const one = robot("/robot1", { stop: stoppedBy("Ada", "/robot1") });
  const two = robot("/robot2", { stop: stoppedBy("Grace", "/robot2") });

  it("are told apart, and each is released by itself", async () => {
    const gateway = fakeGateway();
    const { user } = renderPage(gateway, { robots: [one, two, robot("/robot3")] }, "/ui/robot");
    expect(banner()?.textContent).toMatch(/2 robots are stopped/);
    expect(banner()?.textContent).toMatch(/\/robot1 stopped by Ada.*\/robot2 stopped by Grace/);
    await user.click(button("Release /robot2 …"));
    const dialog = await screen.findByRole("dialog", { name: "Release the stop?" });
    expect(dialog.textContent).toMatch(/\/robot2/);
    await user.click(button("Release"));
    expect(vi.mocked(gateway.release).mock.calls).toEqual([["/robot2"]]);
    await waitFor(() => expect(banner()?.textContent).toMatch(/^\/robot1 stopped by Ada/));
  });

  it("are released together by those who mean all", async () => {
    const gateway = fakeGateway();
    const { user } = renderPage(gateway, { robots: [one, two] }, "/ui/robot");
    await user.click(button("Release all …"));
    await screen.findByRole("dialog", { name: "Release 2 stops?" });
    await user.click(button("Release all"));
    await waitFor(() => expect(banner()).toBeNull());
    expect(vi.mocked(gateway.release).mock.calls).toEqual([["/robot1"], ["/robot2"]]);
  });

  it("are one where it is that of the namespace above", async () => {
    const held = { ...latched("Ada"), robots: ["/", "/robot1", "/robot2"] };
    const robots = [robot("/", { stop: held }), one, two];
    const gateway = fakeGateway();
    const { user } = renderPage(gateway, { stop: held, robots }, "/ui/robot");
    expect(banner()?.textContent).toMatch(
      /^All robots stopped by Ada at [^/]*Robot, \/robot1, \/robot2: Zero/,
    );
    await user.click(button("Release …"));
    await user.click(await screen.findByRole("button", { name: "Release" }));
    await waitFor(() => expect(banner()).toBeNull());
    expect(gateway.release).toHaveBeenCalledTimes(1);
  });

  it("name all robots where each is held by a stop of its own", () => {
    renderPage(fakeGateway(), { robots: [one, two] }, "/ui/robot");
    expect(banner()?.textContent).toMatch(/^All 2 robots are stopped/);
  });

  it("count the robots that they hold, not the stops", () => {
    const arm = robot("/robot2/arm", { stop: stoppedBy("Grace", "/robot2/arm") });
    renderPage(fakeGateway(), { robots: [one, two, arm, robot("/robot3")] }, "/ui/robot");
    expect(banner()?.textContent).toMatch(/^3 robots are stopped.*\/robot2, \/robot2\/arm stopped by Grace/);
  });

  it("do not name a configured robot that does not exist", () => {
    const held = { ...latched("Ada"), robots: ["/", "/robot1"] };
    const none = robot("/", {
      stop: held,
      battery: { ...one.battery, state: null, received_at: null },
      dock: null,
      undock: null,
    });
    renderPage(fakeGateway(), { stop: held, robots: [none, one] }, "/ui/robot");
    expect(banner()?.textContent).toMatch(/^\/robot1 stopped by Ada at [^/]*Zero/);
  });
});

describe("the question whether to release a stop", () => {
  it("is about that stop, also if another one comes meanwhile", async () => {
    const gateway = fakeGateway();
    const first = robot("/robot1", { stop: { ...latched("Ada"), robots: ["/robot1"] } });
    const robots = [robot("/"), first, robot("/robot2")];
    const { store, user } = renderPage(gateway, { robots }, "/ui/robot");
    await user.click(button("Release …"));
    const all = { ...latched("Grace"), robots: ["/", "/robot1", "/robot2"] };
    act(() => store.onEvent({ type: "stop", id: null, time: at(1), robot: "/", stop: all }));
    await waitFor(() => expect(banner()?.textContent).toMatch(/by Grace/));
    await user.click(button("Release"));
    await waitFor(() => expect(vi.mocked(gateway.release).mock.calls).toEqual([["/robot1"]]));
  });
});

describe("a Stop that was not delivered", () => {
  const failing = () =>
    fakeGateway({ stop: vi.fn().mockRejectedValue(new ClientError("offline", "No answer", "down")) });

  it("is said until the gateway answers again, and then what is stopped", async () => {
    const { store, user } = renderPage(failing());
    act(() => store.onConnection({ kind: "closed" }));
    await user.click(button("Stop"));
    expect(await screen.findByText("Stop was NOT delivered to any robot")).toBeDefined();
    act(() => store.onEvent(snapshot({ time: new Date().toISOString() })));
    act(() => store.onConnection({ kind: "snapshot" }));
    expect(await screen.findByText(/No robot is stopped\. Press Stop again/)).toBeDefined();
    expect(screen.queryByText("Stop was NOT delivered to any robot")).toBeNull();
  });

  it("is said no more where somebody else's stop holds", async () => {
    const { store, user } = renderPage(failing());
    await user.click(button("Stop"));
    expect(await screen.findByText("Stop was NOT delivered to any robot")).toBeDefined();
    act(() =>
      store.onEvent({
        type: "stop",
        id: null,
        time: new Date().toISOString(),
        robot: "/",
        stop: latched("Grace"),
      }),
    );
    expect(await screen.findByText("Stopped: Robot.")).toBeDefined();
    expect(screen.queryByText("Stop was NOT delivered to any robot")).toBeNull();
  });
});

describe("a Stop's notice", () => {
  it("is shown although other notices take all the room", async () => {
    const error = new ClientError("offline", "No answer", "down");
    const { user } = renderPage(fakeGateway({ stop: vi.fn().mockRejectedValue(error) }));
    act(() => {
      for (const number of [1, 2, 3, 4, 5])
        notifications.show({ id: `refused ${number}`, message: `Refused ${number}`, autoClose: false });
    });
    await user.click(button("Stop"));
    expect(await screen.findByText("Stop was NOT delivered to any robot")).toBeDefined();
  });
});

describe("the Stop of one robot of several", () => {
  const robots = [robot("/a", { default: true }), robot("/b")];
  const failing = () =>
    fakeGateway({ stop: vi.fn().mockRejectedValue(new ClientError("offline", "No answer", "down")) });
  const stopB = async (gateway = failing()) => {
    const page = renderPage(gateway, { robots }, "/ui/robot?robot=/b", () => fakeGateway());
    await page.user.click(button("Stop /b"));
    return page;
  };

  it("names its robot where it was not delivered", async () => {
    await stopB();
    expect(await screen.findByText("Stop was NOT delivered to /b")).toBeDefined();
  });

  it("names its robot where it was delivered", async () => {
    await stopB(fakeGateway());
    expect(await screen.findByText("Stopped /b")).toBeDefined();
  });

  it("says that it was not delivered although another page is shown by then", async () => {
    let fail = (_: unknown) => {};
    const stop = vi.fn(() => new Promise<never>((_, reject) => (fail = reject)));
    const { user } = await stopB(fakeGateway({ stop }));
    const crumbs = screen.getByRole("navigation", { name: "Breadcrumb" });
    await user.click(within(crumbs).getByRole("link", { name: "Overview" }));
    await waitFor(() => expect(screen.queryByRole("button", { name: "Stop /b" })).toBeNull());
    act(() => fail(new ClientError("gateway_timeout", "The gateway did not answer", "No answer.")));
    expect(await screen.findByText("Stop was NOT delivered to /b")).toBeDefined();
  });

  it("that failed is said until all robots are stopped, also after a Stop of another one", async () => {
    await stopB();
    await screen.findByText("Stop was NOT delivered to /b");
    act(() => showStopped(stopReport(), new Naming([]), ["/a"]));
    expect(await screen.findByText("Stopped /a")).toBeDefined();
    expect(screen.getByText("Stop was NOT delivered to /b")).toBeDefined();
    act(() => showStopped(stopReport(), new Naming([])));
    expect(await screen.findByText("Stopped")).toBeDefined();
    await waitFor(() => expect(screen.queryByText("Stop was NOT delivered to /b")).toBeNull());
  });
});

describe("Stop", () => {
  it("names no robot to stop all, also those that are not below the configured one", async () => {
    const gateway = fakeGateway();
    const robots = [robot("/a", { default: true }), robot("/a/arm"), robot("/b"), robot("/b/arm")];
    const { user } = renderPage(gateway, { robots }, "/ui/robot");
    await user.click(button("Stop"));
    expect(vi.mocked(gateway.stop).mock.calls.map(([, names]) => names)).toEqual([[]]);
    expect(await screen.findByText("Stopped")).toBeDefined();
  });

  it("says which robot it did not reach", async () => {
    const failed = [{ action_name: null, robot: "/b", code: "publish_failed", detail: "no base listens" }];
    const stop = vi.fn().mockResolvedValue(stopReport({ stopped: ["/a"], not_stopped: ["/b"], failed }));
    const robots = [robot("/a", { default: true }), robot("/b")];
    const { user } = renderPage(fakeGateway({ stop }), { robots }, "/ui/robot");
    await user.click(button("Stop"));
    expect(await screen.findByText(/\/b: no base listens \(publish_failed\)/)).toBeDefined();
  });

  it("is answered on the page at once, and says who has not answered yet", async () => {
    let answer: (report: ReturnType<typeof stopReport>) => void = () => {};
    const stop = vi.fn(() => new Promise<ReturnType<typeof stopReport>>((resolve) => (answer = resolve)));
    const { user } = renderPage(fakeGateway({ stop }));
    await user.click(button("Stop"));
    expect(screen.getByText("Stopping …")).toBeDefined();
    await act(async () => answer(stopReport({ unconfirmed: ["/dock"] })));
    expect(await screen.findByText(/Not answered yet: \/dock/)).toBeDefined();
  });

  it("works by Escape twice, from anywhere: in a number field and in a dialog, too", async () => {
    const gateway = fakeGateway();
    const { user } = renderPage(gateway, {}, "/?tab=developer");
    await user.click(await screen.findByLabelText("Voltage (V)"));
    await user.keyboard("{Escape}{Escape}");
    expect(gateway.stop).toHaveBeenCalledTimes(1);
    await user.click(button("Keyboard and name"));
    (await screen.findByRole("dialog")).focus();
    await user.keyboard("{Escape}{Escape}");
    expect(gateway.stop).toHaveBeenCalledTimes(2);
  });

  it("carries the name that was given on this computer", async () => {
    const gateway = fakeGateway();
    const { user } = renderPage(gateway);
    await user.click(button("Keyboard and name"));
    await user.type(await within(await screen.findByRole("dialog")).findByLabelText("Your name"), "Grace");
    expect(ownName()).toBe("Grace");
    await user.click(button("Stop"));
    expect(gateway.stop).toHaveBeenCalledWith("Grace", []);
    setOwnName("  ");
    await user.click(button("Stop"));
    expect(gateway.stop).toHaveBeenLastCalledWith("the dashboard", []);
  });

  it("and what else the keyboard does can be read on the page", async () => {
    const { user } = renderPage(fakeGateway(), { stop: released });
    await user.click(button("Keyboard and name"));
    const dialog = await screen.findByRole("dialog");
    await waitFor(() => expect(dialog.textContent).toMatch(/Escape twice within 0.7 s/));
  });
});

describe("Escape twice", () => {
  function press(keys: DoubleEscape, at: number, change: KeyboardEventInit = {}): boolean {
    const event = new KeyboardEvent("keydown", { key: "Escape", ...change });
    Object.defineProperty(event, "timeStamp", { value: at });
    fireEvent(document.body, event);
    return keys.press(event);
  }

  it("is two presses that are close together, and four are two of those", () => {
    const keys = new DoubleEscape();
    expect([0, 300, 400, 500].map((at) => press(keys, at))).toEqual([false, true, false, true]);
  });

  it("is neither two that are far apart, nor a key that is held, nor another key between", () => {
    const keys = new DoubleEscape();
    expect(press(keys, 0)).toBe(false);
    expect(press(keys, TWICE_WITHIN_MS + 1)).toBe(false);
    const held = new DoubleEscape();
    expect(press(held, 0)).toBe(false);
    expect(press(held, 100, { repeat: true })).toBe(false);
    const other = new DoubleEscape();
    press(other, 0);
    press(other, 100, { key: "a" });
    expect(press(other, 200)).toBe(false);
    expect(press(other, 300, { shiftKey: true })).toBe(false);
    const composing = new DoubleEscape();
    press(composing, 0, { isComposing: true });
    expect(press(composing, 100, { isComposing: true })).toBe(false);
  });
});
