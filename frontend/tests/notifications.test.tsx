import type { Alert } from "@dock-gateway/client";
import { act, screen, waitFor } from "@testing-library/react";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { Naming } from "../src/fleet/names";
import { ALL_ROBOTS } from "../src/fleet/robotChoice";
import { isWanted } from "../src/notifications/Announcer";
// Loaded on demand by the page: on a busy machine their first import takes longer than a test waits.
import "../src/notifications/NotificationsPage";
import { setPreferences } from "../src/notifications/preferences";
import { fakeGateway, renderPage } from "./page";

const LOW: Alert = {
  id: "low",
  etag: '"1"',
  kind: "low_battery",
  robot: "/robot1",
  severity: "warning",
  started_at: "2026-11-23T10:00:00Z",
  title: "Low battery",
  detail: "Send the robot to its dock.",
  goal_id: null,
  acknowledged: null,
};
const STOPPED: Alert = { ...LOW, id: "stop", kind: "stop_latched", severity: "critical", title: "Stopped" };
const QUIET = { desktop: false, sound: false, warnings: true, robots: ALL_ROBOTS };

const open = () => renderPage(fakeGateway(), {}, "/ui/notifications");

beforeEach(() => setPreferences(QUIET));

describe("this browser", () => {
  it("announces alerts that are wanted and not acknowledged", () => {
    const naming = new Naming([{ name: "/robot1", display_name: null, groups: ["hall 1"] }]);
    const hall = { all: false, names: [], groups: ["hall 1"] };
    expect(isWanted(LOW, QUIET, naming)).toBe(true);
    expect(isWanted(LOW, { ...QUIET, warnings: false }, naming)).toBe(false);
    expect(isWanted(STOPPED, { ...QUIET, warnings: false, robots: hall }, naming)).toBe(true);
    expect(isWanted({ ...STOPPED, robot: "/robot2" }, { ...QUIET, robots: hall }, naming)).toBe(false);
    expect(isWanted({ ...LOW, robot: null }, { ...QUIET, robots: hall }, naming)).toBe(true);
    const acknowledged = { by: "Ada", acknowledged_at: LOW.started_at };
    expect(isWanted({ ...LOW, acknowledged }, QUIET, naming)).toBe(false);
  });

  it("shows a notification of each alert that begins, once, and one of a stop of several robots", async () => {
    const shown: { title: string; options: NotificationOptions }[] = [];
    class FakeNotification {
      static permission = "granted";
      static requestPermission = async () => "granted";
      onclick: (() => void) | null = null;
      constructor(title: string, options: NotificationOptions) {
        shown.push({ title, options });
      }
      close() {}
    }
    vi.stubGlobal("Notification", FakeNotification);
    vi.stubGlobal("isSecureContext", true);
    vi.stubGlobal("fetch", async (url: unknown) =>
      url === "/healthz" ? Response.json({}) : new Promise(() => {}),
    );
    setPreferences({ desktop: true });
    const stops = () => shown.filter(({ options }) => options.tag === "stop");
    const { store } = open();
    const alerts = (...all: Alert[]) =>
      act(() => store.onEvent({ type: "alerts", time: LOW.started_at, alerts: all }));
    await screen.findByText("This browser");
    await waitFor(() => {
      alerts(LOW);
      alerts(LOW, STOPPED);
      expect(stops()).not.toEqual([]);
    });
    alerts(LOW, STOPPED);
    expect(stops()).toHaveLength(1);
    expect(stops()[0]).toMatchObject({
      title: "/robot1: Stopped",
      options: { tag: "stop", body: LOW.detail, requireInteraction: true },
    });
    const others = ["/robot2", "/robot3", "/robot4", "/robot5"].map((robot) => ({
      ...STOPPED,
      id: robot,
      robot,
    }));
    shown.length = 0;
    alerts(LOW, STOPPED, ...others.slice(0, 2));
    alerts(LOW, STOPPED, ...others);
    await waitFor(() => expect(shown).toHaveLength(2));
    expect(shown.map(({ title }) => title)).toEqual([
      "/robot1, /robot2, /robot3: Stopped",
      "/robot1, /robot2, /robot3 and 2 more: Stopped",
    ]);
    for (const { options } of shown) expect(options.tag).toBe("stop");
  });
});
