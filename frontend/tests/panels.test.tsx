import type { GatewayEvent } from "@dock-gateway/client";
import { act, screen } from "@testing-library/react";
import { type ComponentType, Profiler } from "react";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { BatteryCard } from "../src/battery/BatteryCard";
import { PublisherCard } from "../src/battery/PublisherCard";
import { DockingCard } from "../src/docking/DockingCard";
import { GoalsCard } from "../src/goals/GoalsTable";
import { CurlCard } from "../src/pages/robot/DeveloperPanels";
import { SceneCard } from "../src/scene/SceneCard";
import { ServicesProvider } from "../src/store/context";
import {
  batteryEvent,
  cmdVel,
  feedback,
  goal,
  START,
  sceneEvent,
  simulator,
  snapshot,
  status,
} from "./events";
import { fakeGateway, renderWithin, robotServices } from "./page";

const PANELS: Record<string, ComponentType> = {
  DockingCard,
  SceneCard,
  BatteryCard,
  PublisherCard,
  GoalsCard,
  CurlCard,
};

describe("the panels of a robot", () => {
  let tell: (...events: GatewayEvent[]) => Promise<string[]>;

  beforeEach(async () => {
    vi.useFakeTimers({ now: START + 50 });
    vi.stubGlobal("fetch", () => new Promise(() => {}));
    const { store, services, fleet } = robotServices(fakeGateway(), null);
    const rendered = new Set<string>();
    renderWithin(
      fleet,
      <ServicesProvider value={services}>
        {Object.entries(PANELS).map(([name, Panel]) => (
          <Profiler key={name} id={name} onRender={(id) => rendered.add(id)}>
            <Panel />
          </Profiler>
        ))}
      </ServicesProvider>,
    );
    /** Tells of events, and which panels were re-rendered, in whole or in part. */
    tell = async (...events) => {
      rendered.clear();
      await act(async () => {
        for (const event of events) store.onEvent(event);
        await vi.advanceTimersByTimeAsync(450);
      });
      return [...rendered].sort();
    };
    await act(async () => {
      store.onEvent(snapshot({ goals: [goal("a")] }));
      store.onConnection({ kind: "snapshot" });
      services.store.setSimulator(simulator);
    });
    // Until half a second, and `tell` goes on until just before the next one: elapsed times are renewed with each.
    await tell(batteryEvent({}, 0.1), feedback("a", 0.1), cmdVel(0.1, 0, 0.1), sceneEvent({}, 0.1));
  });

  it("are not rendered while nothing comes", async () => {
    expect(await tell()).toEqual([]);
  });

  it("show a battery message in the battery's card alone", async () => {
    expect(await tell(batteryEvent({ voltage: 3.21 }, 0.6))).toEqual(["BatteryCard"]);
    expect(screen.getByText("3.21 V")).toBeTruthy();
  });

  it("are not rendered for a message that says the same", async () => {
    expect(await tell(batteryEvent({}, 0.6), cmdVel(0.1, 0, 0.6))).toEqual([]);
  });

  it("show feedback where the goal is, and nowhere else", async () => {
    expect(await tell(feedback("a", 0.6), feedback("a", 0.7))).toEqual(["DockingCard"]);
    expect(screen.getByText(/^3 messages/)).toBeTruthy();
  });

  it("show a velocity and a pose in the picture's card", async () => {
    expect(
      await tell(cmdVel(0.25, 0, 0.6), sceneEvent({ robot: { x: -1.11, y: 0, theta: 0 } }, 0.6)),
    ).toEqual(["SceneCard"]);
    expect(screen.getByTestId("velocity").textContent).toContain("forward 0.25 m/s");
    expect(screen.getByTestId("scene-words").textContent).toContain("−1.11");
  });

  it("show a new status wherever goals are", async () => {
    expect(await tell(status("a", { status: "canceling" }, 0.6))).toEqual(
      expect.arrayContaining(["DockingCard", "GoalsCard"]),
    );
    expect(screen.getAllByText("canceling").length).toBe(2);
  });
});
