import { type Calibration, ClientError } from "@dock-gateway/client";
import { act, fireEvent, screen, waitFor, within } from "@testing-library/react";
import { describe, expect, it, vi } from "vitest";
import { status } from "./events";
import { fakeGateway, isDisabled, renderPage } from "./page";

const CALIBRATED: Calibration = {
  parameters: [
    { name: "external_detection_translation_x", value: -0.2003, before: -0.26 },
    { name: "external_detection_rotation_yaw", value: 0.001, before: 0.1 },
  ],
  yaml: "/connect_to_charging_dock_action_server:\n  ros__parameters:",
};

function offered(change: Parameters<typeof fakeGateway>[0] = {}) {
  const calibrationService = vi.fn(async () => ({ available: true, service: "/calibrate_dock" }));
  const gateway = fakeGateway({ calibrationService, ...change });
  return { gateway, ...renderPage(gateway, {}, "/?tab=developer") };
}

const card = () => screen.findByRole("region", { name: "Calibrate dock" });
const press = (name: string, within_ = screen.getByRole("dialog")) =>
  fireEvent.click(within(within_).getByRole("button", { name }));

describe("the calibration of a dock", () => {
  it("is not shown where the docking server does not offer it", async () => {
    const gateway = fakeGateway();
    renderPage(gateway, {}, "/?tab=developer");
    await waitFor(() => expect(gateway.calibrationService).toHaveBeenCalled());
    expect(screen.queryByRole("region", { name: "Calibrate dock" })).toBeNull();
  });

  it("is confirmed, and shows the new and the previous values, and what to keep", async () => {
    const { gateway } = offered({ calibrate: vi.fn(async () => CALIBRATED) });
    press("Calibrate…", await card());
    expect(screen.getByRole("dialog").textContent).toMatch(/must stand on its dock/);
    expect(gateway.calibrate).not.toHaveBeenCalled();
    press("Calibrate");
    const table = await screen.findByRole("table", { name: "Measured pose" });
    const cells = within(table).getAllByRole("cell");
    expect(cells.map(({ textContent }) => textContent?.replace("\u00a0", " "))).toEqual([
      "translation_x",
      "−0.2003 m",
      "−0.2600 m",
      "rotation_yaw",
      "0.0010 rad",
      "0.1000 rad",
    ]);
    expect(screen.getByText(/until the docking server restarts/)).toBeDefined();
    expect(screen.getByText(/ros__parameters/)).toBeDefined();
    expect(screen.getByRole("button", { name: /the parameter file/ })).toBeDefined();
  });

  it("can be left alone", async () => {
    const { gateway } = offered();
    press("Calibrate…", await card());
    press("Keep the present pose");
    expect(gateway.calibrate).not.toHaveBeenCalled();
  });

  it("says why it was refused", async () => {
    const refused = new ClientError("calibration_refused", "The docking server refused", "the robot moved");
    offered({ calibrate: vi.fn(async () => Promise.reject(refused)) });
    press("Calibrate…", await card());
    press("Calibrate");
    expect((await screen.findByRole("alert")).textContent).toMatch(/The robot moved/);
  });

  it("waits for the end of a goal", async () => {
    const { store } = offered();
    await card();
    expect(isDisabled("Calibrate…")).toBe(false);
    act(() => store.onEvent(status("a", { status: "executing" })));
    await waitFor(() => expect(isDisabled("Calibrate…")).toBe(true));
  });
});
