import { screen, within } from "@testing-library/react";
import axe from "axe-core";
import { describe, expect, it } from "vitest";
import { alert, at, battery, goal, latched, robot, sceneEvent, server, simulator } from "./events";
import { fakeGateway, renderPage } from "./page";

const TAGS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];

/** What axe finds; colours are not drawn here, so contrast is for a real browser to judge. */
async function violations(): Promise<string[]> {
  const { violations } = await axe.run(document.body, {
    runOnly: TAGS,
    rules: { "color-contrast": { enabled: false } },
  });
  return violations.map(
    (violation) => `${violation.id}: ${violation.nodes.map((node) => node.html).join(" ")}`,
  );
}

describe("axe finds nothing", () => {
  it("on the overview of several robots with alerts", async () => {
    const { user } = renderPage(fakeGateway(), {
      robots: [robot("/a"), robot("/b", { goals: [goal("g")], last_goal: goal("l", { status: "aborted" }) })],
      alerts: [
        alert("low"),
        alert("lost", { severity: "critical", goal_id: "g" }),
        alert("seen", { acknowledged: { by: "Ada", at: at(1) } }),
      ],
    });
    await user.click(screen.getByRole("button", { name: "Show 1 more" }));
    expect(await violations()).toEqual([]);
  });

  it("on the empty page", async () => {
    renderPage(fakeGateway());
    expect(await violations()).toEqual([]);
  });

  it("on a page without a gateway", async () => {
    const { store } = renderPage(fakeGateway(), { goals: [goal("a")] });
    store.onConnection({ kind: "closed" });
    expect(await violations()).toEqual([]);
  });

  it("on a page with a simulator and a latched stop, nor in its dialogs", async () => {
    const { store, user } = renderPage(
      fakeGateway({ simulator: async () => simulator }),
      { stop: latched("Ada") },
      "/?tab=developer",
    );
    store.onEvent(sceneEvent({ staging: { x: -0.9, y: 0, theta: 0 } }));
    await screen.findByRole("region", { name: "Simulator" });
    expect(await violations()).toEqual([]);
    await user.click(screen.getByRole("button", { name: "Keyboard and name" }));
    // Asked of the dialog alone: looking through the whole page all the time leaves none to draw the list.
    await within(await screen.findByRole("dialog")).findByLabelText("Your name");
    expect(await violations()).toEqual([]);
  });

  it("on a page that is full of things", async () => {
    const error = { code: "action_server_lost", detail: "it left" };
    const received_at = new Date().toISOString();
    const first = {
      goals: [goal("a", { status: "lost", error }), goal("b", { stalled: true, origin: "external" })],
      battery: {
        state: { ...battery, cell_voltage: [3.9, null] },
        percentage: null,
        implausible: [{ field: "percentage", value: 12, expected: "0 to 1" }],
        age_s: 0,
        stale: false,
        stale_after_s: 2,
        low_below: 0.2,
        received_at,
      },
      battery_publisher: {
        active: true,
        state: battery,
        rate_hz: 1,
        published_count: 3,
        started_at: received_at,
      },
      action_server: { ...server, answering: false },
      robots: [robot("/"), robot("/robot1")],
    } satisfies Parameters<typeof renderPage>[1];
    const { user } = renderPage(fakeGateway(), first, "/ui/robot");
    await screen.findByRole("combobox", { name: "Switch robot" });
    await user.click(screen.getByRole("button", { name: "More values" }));
    await user.click(screen.getByRole("button", { name: "Stop" }));
    expect(await violations()).toEqual([]);
    await user.click(screen.getByRole("tab", { name: "Developer" }));
    await user.click(await screen.findByRole("button", { name: "More fields" }));
    expect(await violations()).toEqual([]);
  });
});
