import type { Extension } from "../../extension/extension";
import { lazyPart } from "../../ui/lazyPart";
import { GoalRule, RobotRules } from "./rules";

export const extension: Extension = {
  name: "automation",
  pages: [
    {
      path: "/ui/automation",
      Page: lazyPart(() => import("./AutomationPage")),
      menu: { name: "Automatic docking", letter: "d", order: 60 },
      at: "gateway",
    },
  ],
  parts: { robotHead: RobotRules, goalOrigin: GoalRule },
};
