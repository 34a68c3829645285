import type { ConnectionInput, EventOf, GatewayEvent } from "@dock-gateway/client";
import { MantineProvider } from "@mantine/core";
import { Notifications } from "@mantine/notifications";
import { QueryClientProvider } from "@tanstack/react-query";
import { act, cleanup, render, screen } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import type { ReactNode } from "react";
import { MemoryRouter } from "react-router";
import { vi } from "vitest";
import type { Gateway } from "../src/api/client";
import { createHttp } from "../src/api/http";
import { placeOf } from "../src/api/places";
import { createQueryClient } from "../src/api/queryClient";
import { ExtensionsProvider } from "../src/extension/context";
import { type Extension, layersOf, startAll } from "../src/extension/extension";
import * as listed from "../src/extensions";
import { FleetProvider, type FleetServices } from "../src/fleet/context";
import { FleetStore } from "../src/fleet/store";
import { App } from "../src/layout/App";
import { theme } from "../src/layout/theme";
import { BatterySeries } from "../src/store/batterySeries";
// Loaded on demand by the page: on a busy machine their first import takes longer than a test waits.
import "../src/pages/robot/DeveloperPanels";
import "../src/pages/robot/RobotSelect";
import type { Services } from "../src/store/context";
import { SceneBuffer } from "../src/store/sceneBuffer";
import { Store } from "../src/store/store";
import {
  goal,
  idlePublisher,
  latchedStops,
  released,
  robot,
  snapshot,
  stopReport,
  undockGoal,
} from "./events";

/** All that there are. */
export const EXTENSIONS: readonly Extension[] = Object.values(listed);

startAll(EXTENSIONS);

/** A gateway that does what it is told, and remembers. */
export function fakeGateway(change: Partial<Gateway> = {}) {
  return {
    dock: vi.fn<Gateway["dock"]>(async () => goal("docked", { status: "accepted" })),
    docks: vi.fn<Gateway["docks"]>(async () => ({
      node: "/docking_server",
      dock_database: null,
      default: null,
      docks: [],
    })),
    undock: vi.fn<Gateway["undock"]>(async () => undockGoal("undocked", { status: "accepted" })),
    cancel: vi.fn<Gateway["cancel"]>(async (id) => goal(id, { status: "canceling" })),
    stop: vi.fn<Gateway["stop"]>(async (by) => stopReport({ canceling: ["a"], stop: latchedStops(by) })),
    release: vi.fn<Gateway["release"]>(async () => released),
    publishOnce: vi.fn<Gateway["publishOnce"]>(async () => {}),
    publishRepeatedly: vi.fn<Gateway["publishRepeatedly"]>(async () => idlePublisher),
    stopPublishing: vi.fn<Gateway["stopPublishing"]>(async () => {}),
    calibrationService: vi.fn<Gateway["calibrationService"]>(async () => ({
      available: false,
      service: "/calibrate_dock",
    })),
    calibrate: vi.fn<Gateway["calibrate"]>(async () => ({ parameters: [], yaml: "" })),
    ...change,
  };
}

/** The robot's store and that of all robots, told the same. */
class BothStores {
  readonly robot = new Store();
  readonly fleet = new FleetStore();

  onEvent(event: GatewayEvent): void {
    this.robot.onEvent(event);
    this.fleet.onEvent(event);
  }

  onConnection(input: ConnectionInput): void {
    this.robot.onConnection(input);
    this.fleet.onConnection(input);
  }
}

/** What panels read, live with a snapshot that was just taken, or not live where `first` is null. */
export function robotServices(
  gateway: Gateway,
  first: Partial<EventOf<"snapshot">> | null = {},
  gatewayOf: FleetServices["gatewayOf"] = () => gateway,
) {
  const store = new BothStores();
  const scene = new SceneBuffer();
  const http = createHttp("http://gateway:8000");
  const services: Services = {
    robot: null,
    gateway,
    store: store.robot,
    series: new BatterySeries(),
    scene,
    layers: layersOf(EXTENSIONS).map((each) => each.ofRobot(http, null)),
  };
  const fleet: FleetServices = {
    http,
    httpOf: (name) => createHttp(`http://gateway:8000${placeOf(name).prefix}`),
    gateway,
    gatewayOf,
    store: store.fleet,
    openRobot: (robot) => ({ services: { ...services, robot }, close: () => {} }),
  };
  store.robot.onScene((event) => scene.push(event.scene, performance.now(), Date.parse(event.time)));
  if (first !== null) {
    store.onEvent(snapshot({ time: new Date().toISOString(), ...first }));
    store.onConnection({ kind: "snapshot" });
  }
  return { store, services, fleet };
}

/** Whether a button cannot be used; it can have the focus all the same, so that its reason can be read. */
export function isDisabled(name: string): boolean {
  return screen.getByRole("button", { name }).ariaDisabled === "true";
}

/** What a screen reader says of a button besides its name. */
export function descriptionOf(button: HTMLElement): string {
  const ids = button.getAttribute("aria-describedby")?.split(" ") ?? [];
  return ids.map((id) => document.getElementById(id)?.textContent ?? "").join(" ");
}

/** Presses Escape, at a time of the browser's (ms): whether two are one Stop does not depend on a busy machine. */
export function pressEscape(time: number): void {
  const event = new KeyboardEvent("keydown", { key: "Escape", bubbles: true, cancelable: true });
  Object.defineProperty(event, "timeStamp", { value: time });
  act(() => void (document.activeElement ?? document.body).dispatchEvent(event));
}

/** Renders something within all that a page has. */
export function renderWithin(
  fleet: FleetServices,
  children: ReactNode,
  path = "/",
  extensions: readonly Extension[] = EXTENSIONS,
) {
  render(
    <MantineProvider theme={theme} env="test" withCssVariables={false}>
      <Notifications />
      <QueryClientProvider client={createQueryClient()}>
        <FleetProvider value={fleet}>
          <ExtensionsProvider value={extensions}>
            <MemoryRouter initialEntries={[path]} useTransitions={false}>
              {children}
            </MemoryRouter>
          </ExtensionsProvider>
        </FleetProvider>
      </QueryClientProvider>
    </MantineProvider>,
  );
}

/** The page at a path. */
export function renderPage(
  gateway: Gateway,
  first: Partial<EventOf<"snapshot">> | null = {},
  path = "/",
  gatewayOf: FleetServices["gatewayOf"] = () => gateway,
  extensions: readonly Extension[] = EXTENSIONS,
) {
  const { store, fleet } = robotServices(gateway, first, gatewayOf);
  renderWithin(fleet, <App />, path, extensions);
  return { store, user: userEvent.setup({ delay: null, pointerEventsCheck: 0 }) };
}

/** Shows the table of robots once: it is loaded when it is first shown. */
export async function loadRobotTable(): Promise<void> {
  renderPage(fakeGateway(), { robots: [robot("/robot1"), robot("/robot2")] });
  await screen.findByRole("table");
  cleanup();
}
