import { ClientError, type EventOf } from "@dock-gateway/client";
import { act, screen, waitFor } from "@testing-library/react";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { adviceFor, titleOf } from "../../../src/api/errors";
import * as requests from "../../../src/extensions/simulator/requests";
import { SCENE_STALE_MS } from "../../../src/store/context";
import { at, robot, sceneEvent, simulator } from "../../events";
import { fakeGateway, isDisabled, renderPage } from "../../page";

const words = () => screen.getByTestId("scene-words").textContent;

const api = { get: vi.fn(), reset: vi.fn(), place: vi.fn(), switchFault: vi.fn() };

function simulatorEvent(change: Partial<typeof simulator> = {}): EventOf<"simulator"> {
  return { type: "simulator", time: at(1), robot: "/", simulator: { ...simulator, ...change } };
}

// Time stands still: on a busy machine a scene would be history before it is looked at.
beforeEach(() => {
  vi.spyOn(requests, "useSimulatorApi").mockReturnValue(api);
  vi.spyOn(performance, "now").mockReturnValue(1000);
  for (const each of [api.reset, api.place, api.switchFault]) each.mockReset().mockResolvedValue(undefined);
  api.get.mockReset().mockResolvedValue(simulator);
});
afterEach(() => vi.restoreAllMocks());

function simulatedPage(path = "/") {
  const page = renderPage(fakeGateway(), { robots: [robot("/")] }, path);
  act(() => page.store.onEvent(sceneEvent()));
  return page;
}

describe("the view from above", () => {
  it("teaches what is missing where nobody says where the robot is, and asks for no simulator", async () => {
    renderPage(fakeGateway());
    expect(words()).toMatch(/Nothing to draw yet.*nav_msgs\/Odometry.*dock-gateway up/);
    expect(screen.queryByRole("region", { name: "Simulator" })).toBeNull();
    expect(await screen.findByTestId("connection")).toBeDefined();
    expect(api.get).not.toHaveBeenCalled();
  });

  it("is said in words, and who reads the picture is told where they are", async () => {
    simulatedPage();
    await waitFor(() => expect(words()).toMatch(/^Robot at x −1.50 m, y 0.40 m, heading −17°. Not docked/));
    const picture = screen.getByRole("application", { name: /Picture of the robot/ });
    expect(picture.getAttribute("aria-describedby")).toBe(screen.getByTestId("scene-words").id);
    expect(picture.tabIndex).toBe(0);
  });

  it("renders nothing for the events themselves, and has the latest in its words", async () => {
    const { store } = simulatedPage();
    await screen.findByText(/Drag the robot/);
    const observer = new MutationObserver(() => {});
    observer.observe(document.body, {
      childList: true,
      characterData: true,
      attributes: true,
      subtree: true,
    });
    act(() => {
      for (let step = 1; step <= 40; step += 1) {
        store.onEvent(sceneEvent({ robot: { x: -1.5 + step / 100, y: 0, theta: 0 } }, step));
      }
    });
    expect(observer.takeRecords()).toEqual([]);
    observer.disconnect();
    await waitFor(() => expect(words()).toMatch(/x −1.10 m/));
  });

  it("says where the machine is too slow for the simulation", async () => {
    const { store } = simulatedPage();
    await screen.findByText(/Drag the robot/);
    expect(screen.queryByText(/machine is too slow/)).toBeNull();
    act(() => store.onEvent(simulatorEvent({ too_slow: true, real_time_factor: 0.4 })));
    expect(
      await screen.findByText(/machine is too slow for the simulation.* 0.40 of real time/),
    ).toBeDefined();
    act(() => store.onEvent(simulatorEvent()));
    await waitFor(() => expect(screen.queryByText(/machine is too slow/)).toBeNull());
  });

  it("is of a real robot: no simulator is asked for, and nothing can be placed", async () => {
    const { store } = renderPage(fakeGateway());
    act(() => store.onEvent(sceneEvent({ frame: "odom", dock: null })));
    await waitFor(() => expect(words()).toMatch(/in odometry’s frame, which drifts/));
    expect(api.get).not.toHaveBeenCalled();
    expect(screen.queryByText(/Drag the robot/)).toBeNull();
  });

  it("says when what it shows is history", async () => {
    simulatedPage();
    await waitFor(() => expect(words()).toMatch(/^Robot at/));
    vi.mocked(performance.now).mockReturnValue(1000 + SCENE_STALE_MS + 100);
    await waitFor(() => expect(words()).toMatch(/^This is how it was last seen/));
  });
});

describe("the simulator", () => {
  const developerPage = () => simulatedPage("/?tab=developer");

  it("is asked for when there is a true pose, and shows its state", async () => {
    developerPage();
    expect(await screen.findByRole("region", { name: "Simulator" })).toBeDefined();
    const stuck = screen.getByRole<HTMLInputElement>("switch", { name: "Stuck wheel" });
    expect(stuck.checked).toBe(true);
    expect(screen.getByRole<HTMLInputElement>("switch", { name: "Dead charger" }).checked).toBe(false);
    expect(screen.getByText(/motors off: blocked/)).toBeDefined();
  });

  it("is told by events, and gone when it goes", async () => {
    const { store } = developerPage();
    await screen.findByRole("region", { name: "Simulator" });
    act(() =>
      store.onEvent({ type: "robots", time: at(1), robots: [robot("/", { docked: true })], gone: [] }),
    );
    expect(await screen.findByText("docked")).toBeDefined();
    await waitFor(() => expect(words()).toMatch(/ Docked\.$/));
    act(() => store.onEvent(simulatorEvent({ available: false })));
    await waitFor(() => expect(screen.queryByRole("region", { name: "Simulator" })).toBeNull());
  });

  it("breaks what is switched", async () => {
    const { user } = developerPage();
    await user.click(await screen.findByRole("switch", { name: "Dead charger" }));
    expect(api.switchFault).toHaveBeenCalledWith("dead_charger", true);
    await user.click(screen.getByRole("switch", { name: "Stuck wheel" }));
    expect(api.switchFault).toHaveBeenLastCalledWith("stuck_wheel", false);
  });

  it("is reset, and says why where that did not work", async () => {
    const error = new ClientError("simulator_timeout", "The simulator does not answer", "no answer");
    api.reset.mockRejectedValueOnce(error);
    const { user } = developerPage();
    const reset = await screen.findByRole("button", { name: "Reset" });
    await user.click(reset);
    expect(await screen.findByText(/Reset did not work/)).toBeDefined();
    await user.click(reset);
    await waitFor(() => expect(screen.queryByText(/Reset did not work/)).toBeNull());
  });

  it("places the robot by numbers, and not by half a number", async () => {
    const { user } = developerPage();
    const heading = await screen.findByLabelText("Heading (°)");
    await user.clear(heading);
    expect(isDisabled("Place")).toBe(true);
    await user.type(heading, "90");
    await user.click(screen.getByRole("button", { name: "Place" }));
    expect(api.place).toHaveBeenCalledWith({ x: -1.5, y: 0.4, theta: Math.PI / 2 });
  });

  it("places the robot by keyboard in the picture, and says where", async () => {
    const { store, user } = simulatedPage();
    await screen.findByText(/Drag the robot/);
    screen.getByRole("application", { name: /Picture of the robot/ }).focus();
    act(() => store.onEvent(sceneEvent({}, 1))); // at the last moment: a picture that is old cannot be changed
    await user.keyboard("{ArrowRight}");
    expect(await screen.findByText(/To be placed at x −1.45 m, y 0.40 m/)).toBeDefined();
    await user.keyboard("{Enter}");
    expect(api.place).toHaveBeenCalledWith({ x: -1.45, y: 0.4, theta: -0.3 });
    await waitFor(() => expect(screen.queryByText(/To be placed/)).toBeNull());
  });

  it("is out of reach while the gateway is", async () => {
    const { store } = developerPage();
    await screen.findByRole("region", { name: "Simulator" });
    act(() => store.onConnection({ kind: "closed" }));
    expect(isDisabled("Reset")).toBe(true);
    expect(screen.getByRole<HTMLInputElement>("switch", { name: "Dead charger" }).disabled).toBe(true);
  });
});

it("has words for its error", () => {
  const error = new ClientError("simulator_not_found", "Not found", "there is no simulator of /");
  expect(titleOf(error)).toBe("There is no simulator");
  expect(adviceFor(error.code)).toMatch(/dock_simulator/);
});
