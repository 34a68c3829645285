import type { Extension } from "../../extension/extension";
import { FleetMaps } from "./fleetMaps";
import { RobotMaps } from "./robotMaps";

export const extension: Extension = {
  name: "maps",
  layers: {
    robotTopics: ["map", "scan", "path"],
    fleetTopics: ["maps"],
    ofRobot: (http, robot) => new RobotMaps(http, robot),
    ofFleet: (httpOf) => new FleetMaps(httpOf),
  },
};
