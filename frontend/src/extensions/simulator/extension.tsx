import type { Extension } from "../../extension/extension";
import { lazyPart } from "../../ui/lazyPart";
import { SimulatedPlacing } from "./placing";

export const extension: Extension = {
  name: "simulator",
  parts: { developer: lazyPart(() => import("./SimulatorCard")), placing: SimulatedPlacing },
};
