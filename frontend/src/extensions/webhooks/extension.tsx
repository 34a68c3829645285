import type { Extension } from "../../extension/extension";
import { lazyPart } from "../../ui/lazyPart";

export const extension: Extension = {
  name: "webhooks",
  parts: { notifications: lazyPart(() => import("./Webhooks")) },
};
