import type { Http } from "@dock-gateway/client";
import { createGateway } from "../api/client";
import { openStream, type StreamLocation, streamUrl } from "../stream/stream";
import { BatterySeries, believed } from "./batterySeries";
import type { Services } from "./context";
import { SceneBuffer } from "./sceneBuffer";
import { Store } from "./store";
import { Surroundings } from "./surroundings";

export interface OpenRobot {
  services: Services;
  close(): void;
}

/** Reads along with one robot, the configured one for null, until it is closed. */
export function openRobot(location: StreamLocation, http: Http, robot: string | null): OpenRobot {
  const store = new Store();
  const series = new BatterySeries();
  store.onBattery((event) => {
    series.push(Date.parse(event.time), believed({ ...event, state: event.battery }));
  });
  const scene = new SceneBuffer();
  store.onScene((event) => scene.push(event.scene, performance.now(), Date.parse(event.time)));
  const around = new Surroundings();
  store.onAround((event) => around.push(event, performance.now()));
  const close = openStream(
    streamUrl(location, { include: "battery,cmd_vel,system,scene,map,scan,path", robot }),
    store,
  );
  return { services: { robot, gateway: createGateway(http, robot), store, series, scene, around }, close };
}
