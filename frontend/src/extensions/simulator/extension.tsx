import type { Extension } from "../../extension/extension";
import { lazyPart } from "../../ui/lazyPart";
import { usePlacing } from "./placing";

export const extension: Extension = {
  name: "simulator",
  parts: { developer: lazyPart(() => import("./SimulatorCard")) },
  placing: usePlacing,
};
