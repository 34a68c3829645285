import { addErrorWords } from "../../api/errors";
import type { Extension } from "../../extension/extension";
import { lazyPart } from "../../ui/lazyPart";
import { SimulatedPlacing } from "./placing";

export const extension: Extension = {
  name: "simulator",
  parts: { developer: lazyPart(() => import("./SimulatorCard")), placing: SimulatedPlacing },
  start: () =>
    addErrorWords({
      simulator_not_found: {
        title: "There is no simulator",
        advice: "Start it: dock-gateway up, or dock_simulator.",
      },
    }),
};
