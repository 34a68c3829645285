import { MantineProvider } from "@mantine/core";
import { Notifications } from "@mantine/notifications";
import { QueryClientProvider } from "@tanstack/react-query";
import { render } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { vi } from "vitest";
import type { Gateway } from "../src/api/client";
import { createQueryClient } from "../src/api/queryClient";
import type { EventOf } from "../src/api/types";
import { BatterySeries } from "../src/battery/series";
import { App } from "../src/layout/App";
import { theme } from "../src/layout/theme";
import { SceneBuffer } from "../src/scene/buffer";
import { ServicesProvider } from "../src/store/context";
import { Store } from "../src/store/store";
import { goal, idlePublisher, latched, released, snapshot, stopReport, undockGoal } from "./events";

/** A gateway that does what it is told, and remembers. */
export function fakeGateway(change: Partial<Gateway> = {}) {
  return {
    dock: vi.fn<Gateway["dock"]>(async () => goal("docked", { status: "accepted" })),
    undock: vi.fn<Gateway["undock"]>(async () => undockGoal("undocked", { status: "accepted" })),
    cancel: vi.fn<Gateway["cancel"]>(async (_verb, id) => goal(id, { status: "canceling" })),
    stop: vi.fn<Gateway["stop"]>(async (by) => stopReport({ canceling: ["a"], stop: latched(by) })),
    release: vi.fn<Gateway["release"]>(async () => released),
    goal: vi.fn<Gateway["goal"]>(async (_verb, id) => goal(id)),
    goals: vi.fn<Gateway["goals"]>(async () => ({ goals: [], next_cursor: null })),
    publishOnce: vi.fn<Gateway["publishOnce"]>(async () => {}),
    publishRepeatedly: vi.fn<Gateway["publishRepeatedly"]>(async () => idlePublisher),
    stopPublishing: vi.fn<Gateway["stopPublishing"]>(async () => {}),
    simulator: vi.fn<Gateway["simulator"]>(async () => null),
    resetSimulator: vi.fn<Gateway["resetSimulator"]>(async () => {}),
    placeRobot: vi.fn<Gateway["placeRobot"]>(async () => {}),
    switchFault: vi.fn<Gateway["switchFault"]>(async () => {}),
    ...change,
  };
}

/** The page, live with a snapshot that was just taken, or not live where `first` is null. */
export function renderPage(gateway: Gateway, first: Partial<EventOf<"snapshot">> | null = {}) {
  const store = new Store();
  const scene = new SceneBuffer();
  store.onScene((event) => scene.push(event.scene, performance.now()));
  if (first !== null) {
    store.onEvent(snapshot({ time: new Date().toISOString(), ...first }));
    store.onConnection({ kind: "snapshot" });
  }
  render(
    <MantineProvider theme={theme} env="test">
      <Notifications />
      <QueryClientProvider client={createQueryClient()}>
        <ServicesProvider value={{ gateway, store, series: new BatterySeries(), scene }}>
          <App />
        </ServicesProvider>
      </QueryClientProvider>
    </MantineProvider>,
  );
  return { store, user: userEvent.setup() };
}
