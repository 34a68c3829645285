import { placeOf } from "./api/places";
import { apiAddress, sitePrefix } from "./api/site";
import "./layout/styles";
import { MantineProvider } from "@mantine/core";
import { Notifications } from "@mantine/notifications";
import { QueryClientProvider } from "@tanstack/react-query";
import { StrictMode } from "react";
import { createRoot } from "react-dom/client";
import { BrowserRouter } from "react-router";
import { createGateway } from "./api/client";
import { createHttp } from "./api/http";
import { createQueryClient, pauseWhileUnseen } from "./api/queryClient";
import { session } from "./api/session";
import { ExtensionsProvider } from "./extension/context";
import { type Extension, layersOf, startAll } from "./extension/extension";
import * as listed from "./extensions";
import { FleetProvider, type FleetServices } from "./fleet/context";
import { FleetStore } from "./fleet/store";
import { App } from "./layout/App";
import { cssVariables, theme } from "./layout/theme";
import { openRobot } from "./store/openRobot";
import { openStream, streamUrl } from "./stream/stream";

const extensions: readonly Extension[] = Object.values(listed);
startAll(extensions);
// Back and Forward between all sites and one: the page of each is one of its own.
const prefix = sitePrefix();
window.addEventListener("popstate", () => sitePrefix() !== prefix && window.location.reload());
const { location } = window;
const http = createHttp(apiAddress());
const httpOf = (name: string) => {
  const place = placeOf(name);
  return place.prefix === "" ? http : createHttp(location.origin + place.prefix);
};
const store = new FleetStore();
const fleet: FleetServices = {
  http,
  gateway: createGateway(http),
  httpOf,
  gatewayOf: (robot) =>
    robot === null ? createGateway(http) : createGateway(httpOf(robot), placeOf(robot).name),
  store,
  openRobot: (robot) => openRobot(location, http, robot, layersOf(extensions)),
};

const container = document.getElementById("root");
if (container === null) throw new Error("index.html has no #root");
const root = createRoot(container);
// Asked by index.html while the scripts were loading. Nothing is shown before, so that no login and no page flashes up.
await session.ask();
pauseWhileUnseen();
openStream(streamUrl(location, { include: "system,fleet", feedback: "false" }), store);
root.render(
  <StrictMode>
    <MantineProvider theme={theme} cssVariablesResolver={cssVariables} defaultColorScheme="auto">
      <Notifications position="bottom-right" zIndex={400} />
      <QueryClientProvider client={createQueryClient()}>
        <FleetProvider value={fleet}>
          <ExtensionsProvider value={extensions}>
            {/* A change of the address is on the page at once: the next one begins with it. */}
            <BrowserRouter basename={`${prefix}/`} useTransitions={false}>
              <App />
            </BrowserRouter>
          </ExtensionsProvider>
        </FleetProvider>
      </QueryClientProvider>
    </MantineProvider>
  </StrictMode>,
);
