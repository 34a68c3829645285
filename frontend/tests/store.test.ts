// @vitest-environment jsdom

import type { GatewayEvent } from "@dock-gateway/client";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { BEAT_MS } from "../src/clock/beat";
import { Store } from "../src/store/store";
import { RENDER_INTERVAL_MS } from "../src/store/streamStore";
import { at, batteryEvent, feedback, goal, result, START, snapshot, status } from "./events";

/** Until the first frame after the next beat. */
const SOON_MS = BEAT_MS + 20;

describe("Store", () => {
  beforeEach(() => {
    vi.useFakeTimers({ now: START });
  });

  it("tells subscribers at most five times a second", () => {
    const store = new Store();
    store.onEvent(snapshot({ goals: [goal("a")] }));
    vi.advanceTimersByTime(1000);
    const listener = vi.fn();
    store.subscribe("goals", listener);
    for (let count = 0; count < 100; count += 1) {
      store.onEvent(feedback("a", count / 100));
      vi.advanceTimersByTime(10);
    }
    vi.advanceTimersByTime(RENDER_INTERVAL_MS);
    expect(listener.mock.calls.length).toBeGreaterThanOrEqual(5);
    expect(listener.mock.calls.length).toBeLessThanOrEqual(7);
    expect(store.get("goals").get("a")?.feedback_count).toBe(100);
  });

  it("tells of a topic only those who asked for it", () => {
    const store = new Store();
    const goals = vi.fn();
    const battery = vi.fn();
    store.subscribe("goals", goals);
    const unsubscribe = store.subscribe("battery", battery);
    store.onEvent(batteryEvent());
    vi.advanceTimersByTime(SOON_MS);
    expect(battery).toHaveBeenCalledTimes(1);
    expect(goals).not.toHaveBeenCalled();
    unsubscribe();
    store.onEvent(batteryEvent());
    vi.advanceTimersByTime(2 * RENDER_INTERVAL_MS);
    expect(battery).toHaveBeenCalledTimes(1);
  });

  it("shows nothing while nobody can see the page, loses nothing, and shows all of it when somebody can", () => {
    const store = new Store();
    store.onEvent(snapshot({ goals: [goal("a")] }));
    store.onConnection({ kind: "snapshot" });
    const goals = vi.fn();
    const plot = vi.fn();
    store.subscribe("goals", goals);
    store.onBattery(plot);
    // A browser draws no frames of a page that is hidden.
    let frame: FrameRequestCallback = () => {};
    const request = vi.spyOn(window, "requestAnimationFrame").mockImplementation((callback) => {
      frame = callback;
      return 1;
    });
    for (let count = 1; count <= 100; count += 1) {
      store.onEvent(feedback("a", count));
      store.onEvent(batteryEvent({}, count));
      vi.advanceTimersByTime(100);
    }
    expect(goals).not.toHaveBeenCalled();
    expect(plot).toHaveBeenCalledTimes(100);
    expect(request).toHaveBeenCalledTimes(1);
    frame(0);
    expect(goals).toHaveBeenCalledTimes(1);
    expect(store.get("goals").get("a")?.feedback_count).toBe(100);
  });

  it("lists the same goals for as long as only feedback comes", () => {
    const store = new Store();
    store.onEvent(snapshot({ goals: [goal("a")] }));
    vi.advanceTimersByTime(RENDER_INTERVAL_MS);
    const list = store.get("courses");
    expect(list.map((each) => each.goal_id)).toEqual(["a"]);
    const later = (event: GatewayEvent) => {
      store.onEvent(event);
      vi.advanceTimersByTime(2 * RENDER_INTERVAL_MS);
      return store.get("courses");
    };
    expect(later(feedback("a"))).toBe(list);
    expect(later(batteryEvent())).toBe(list);
    expect(store.get("goals").get("a")?.feedback_count).toBe(1);
    const [staged] = later(status("a", { stage: "CONTROLLING" }));
    expect(staged?.stage).toBe("CONTROLLING");
    const [stalled] = later(status("a", { stage: "CONTROLLING", stalled: true }));
    expect(stalled?.stalled).toBe(true);
    const [going] = later(feedback("a", 5));
    expect(going?.stalled).toBe(false);
    const [ended] = later(result("a"));
    expect(ended?.status).toBe("succeeded");
    expect(later(status("b", { created_at: at(9) })).map((each) => each.goal_id)).toEqual(["b", "a"]);
  });

  it("shows the same object until something changes, also while more is coming in", () => {
    const store = new Store();
    store.onEvent(snapshot());
    vi.advanceTimersByTime(RENDER_INTERVAL_MS);
    store.onEvent(status("a"));
    vi.advanceTimersByTime(2 * RENDER_INTERVAL_MS);
    const shown = store.get("goals");
    expect(shown.size).toBe(1);
    store.onEvent(status("b"));
    expect(store.get("goals")).toBe(shown);
    vi.advanceTimersByTime(2 * RENDER_INTERVAL_MS);
    expect(store.get("goals").size).toBe(2);
  });

  it("hands every battery message to the plot, duplicates excepted", () => {
    const store = new Store();
    const listener = vi.fn();
    const unsubscribe = store.onBattery(listener);
    const event = batteryEvent();
    store.onEvent(event);
    store.onEvent(event);
    store.onEvent(batteryEvent());
    expect(listener).toHaveBeenCalledTimes(2);
    unsubscribe();
    store.onEvent(batteryEvent());
    expect(listener).toHaveBeenCalledTimes(2);
  });

  it("shows a change of the connection at once", () => {
    const store = new Store();
    store.onEvent(snapshot());
    store.onConnection({ kind: "snapshot" });
    expect(store.get("connection").phase).toBe("live");
    store.onConnection({ kind: "closed" });
    expect(store.get("connection").phase).toBe("reconnecting");
  });

  it("knows the gateway's time though the clocks differ", () => {
    const store = new Store();
    vi.setSystemTime(START + 60_000);
    store.onEvent(snapshot());
    expect(store.gatewayNow()).toBe(START);
  });

  it("shows goals from answers at once", () => {
    const store = new Store();
    store.addGoals([goal("a")]);
    expect(store.get("goals").has("a")).toBe(true);
  });
});
