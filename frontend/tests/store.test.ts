import { beforeEach, describe, expect, it, vi } from "vitest";
import { RENDER_INTERVAL_MS } from "../src/store/shown";
import { Store } from "../src/store/store";
import { batteryEvent, feedback, goal, START, snapshot, status } from "./events";

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
    expect(battery).toHaveBeenCalledTimes(1);
    expect(goals).not.toHaveBeenCalled();
    unsubscribe();
    vi.advanceTimersByTime(RENDER_INTERVAL_MS);
    store.onEvent(batteryEvent());
    expect(battery).toHaveBeenCalledTimes(1);
  });

  it("shows the same object until something changes, also while more is coming in", () => {
    const store = new Store();
    store.onEvent(snapshot());
    vi.advanceTimersByTime(RENDER_INTERVAL_MS);
    store.onEvent(status("a"));
    const shown = store.get("goals");
    store.onEvent(status("b"));
    expect(store.get("goals")).toBe(shown);
    vi.advanceTimersByTime(RENDER_INTERVAL_MS);
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

  it("takes up goals from answers", () => {
    const store = new Store();
    store.addGoals([goal("a")]);
    expect(store.get("goals").has("a")).toBe(true);
  });
});
