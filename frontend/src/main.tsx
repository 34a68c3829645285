import "@mantine/core/styles.css";
import "@mantine/notifications/styles.css";
import "./layout/global.css";
import { MantineProvider } from "@mantine/core";
import { Notifications } from "@mantine/notifications";
import { QueryClientProvider } from "@tanstack/react-query";
import { StrictMode } from "react";
import { createRoot } from "react-dom/client";
import { createGateway } from "./api/client";
import { createQueryClient } from "./api/queryClient";
import { BatterySeries } from "./battery/series";
import { App } from "./layout/App";
import { cssVariables, theme } from "./layout/theme";
import { SceneBuffer } from "./scene/buffer";
import { ServicesProvider } from "./store/context";
import { Store } from "./store/store";
import { openStream, streamUrl } from "./stream/stream";

const store = new Store();
const series = new BatterySeries();
store.onBattery((event) => {
  series.push(Date.parse(event.time), event.battery.percentage, event.battery.voltage);
});
const scene = new SceneBuffer();
store.onScene((event) => scene.push(event.scene, performance.now()));
openStream(streamUrl(window.location), store);

const root = document.getElementById("root");
if (root === null) throw new Error("index.html has no #root");
createRoot(root).render(
  <StrictMode>
    <MantineProvider theme={theme} cssVariablesResolver={cssVariables} defaultColorScheme="auto">
      <Notifications position="bottom-right" zIndex={400} />
      <QueryClientProvider client={createQueryClient()}>
        <ServicesProvider value={{ gateway: createGateway(window.location.origin), store, series, scene }}>
          <App />
        </ServicesProvider>
      </QueryClientProvider>
    </MantineProvider>
  </StrictMode>,
);
