import type { Extension } from "../../extension/extension";
import { lazyPart } from "../../ui/lazyPart";
import { RobotDockingTime } from "./RobotDockingTime";

export const extension: Extension = {
  name: "statistics",
  pages: [
    {
      path: "/ui/statistics",
      Page: lazyPart(() => import("./StatisticsPage")),
      menu: { name: "Statistics", letter: "s", order: 50 },
    },
  ],
  parts: { robotPanels: RobotDockingTime },
};
