import type { Extension } from "../../extension/extension";
import { lazyPart } from "../../ui/lazyPart";

export const extension: Extension = {
  name: "simulator",
  parts: { developer: lazyPart(() => import("./SimulatorCard")) },
};
