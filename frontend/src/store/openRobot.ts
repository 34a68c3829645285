import type { Http, Include } from "@dock-gateway/client";
import { createGateway } from "../api/client";
import { openStream, type StreamLocation, streamUrl } from "../stream/stream";
import { BatterySeries, believed } from "./batterySeries";
import type { Services } from "./context";
import type { Layers } from "./layers";
import { SceneBuffer } from "./sceneBuffer";
import { Store } from "./store";

export interface OpenRobot {
  services: Services;
  close(): void;
}

const TOPICS: readonly Include[] = ["battery", "cmd_vel", "system", "scene"];

/**
 * Reads along with one robot, the configured one for null, until it is closed.
 *
 * @param drawn What extensions draw in its picture.
 */
export function openRobot(
  location: StreamLocation,
  http: Http,
  robot: string | null,
  drawn: readonly Layers[],
): OpenRobot {
  const store = new Store();
  const series = new BatterySeries();
  store.onBattery((event) => {
    const state = believed(event.battery);
    if (state !== null) series.push(Date.parse(event.time), state);
  });
  const scene = new SceneBuffer();
  store.onScene((event) => scene.push(event.scene, performance.now(), Date.parse(event.time)));
  const layers = drawn.map((each) => each.ofRobot(http, robot));
  const include = [...TOPICS, ...drawn.flatMap(({ robotTopics }) => robotTopics)].join(",");
  const close = openStream(streamUrl(location, { include, robot }), {
    onEvent: (event) => {
      store.onEvent(event);
      for (const layer of layers) layer.onEvent(event, performance.now());
    },
    onConnection: store.onConnection,
  });
  return { services: { robot, gateway: createGateway(http, robot), store, series, scene, layers }, close };
}
