import type { Extension } from "../../extension/extension";
import { lazyPart } from "../../ui/lazyPart";

export const extension: Extension = {
  name: "chargers",
  pages: [
    {
      path: "/ui/docks",
      Page: lazyPart(() => import("./DocksPage")),
      menu: { name: "Docks", letter: "k", order: 65 },
      at: "gateway",
    },
  ],
};
