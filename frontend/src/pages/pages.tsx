import type { ComponentType } from "react";
import { ofSites } from "../api/places";
import { useSession } from "../api/session";
import { pageSite } from "../api/site";
import { useExtensions } from "../extension/context";
import { type Page, pagesOf } from "../extension/extension";
import { lazyPart } from "../ui/lazyPart";
import OverviewPage from "./overview/OverviewPage";
import RobotPage from "./robot/RobotPage";

const HelpPage = lazyPart(() => import("../help/HelpPage"));

const lazy = (
  path: string,
  load: () => Promise<{ default: ComponentType }>,
  more: Partial<Page> = {},
): Page => ({
  path,
  Page: lazyPart(load),
  ...more,
});

/** The pages of the core. */
const CORE: readonly Page[] = [
  { path: "/", Page: OverviewPage, at: "gateway", menu: { name: "Overview", letter: "o", order: 0 } },
  { path: "/ui/robot", Page: RobotPage, at: "gateway" },
  lazy("/ui/map", () => import("./map/MapPage"), {
    at: "gateway",
    menu: { name: "Map", letter: "m", order: 20 },
  }),
  lazy("/ui/goals", () => import("../goals/GoalsPage"), { menu: { name: "Goals", letter: "g", order: 30 } }),
  lazy("/ui/goals/:goalId", () => import("../goals/GoalPage"), { at: "gateway" }),
  lazy("/ui/actions", () => import("../actions/ActionsPage"), {
    at: "gateway",
    menu: { name: "Actions", letter: "a", order: 40 },
  }),
  lazy("/ui/actions/*", () => import("../actions/ActionPage"), { at: "gateway" }),
  lazy("/ui/graph", () => import("../graph/GraphPage"), {
    at: "gateway",
    menu: { name: "Graph", letter: "r", order: 70 },
  }),
  lazy("/ui/notifications", () => import("../notifications/NotificationsPage"), {
    menu: { name: "Notifications", letter: "n", order: 80, button: true },
  }),
  { path: "/ui/help/*", Page: HelpPage },
  { path: "/ui/help", Page: HelpPage, menu: { name: "Help", letter: "h", order: 90, button: true } },
];

/** The login is that of the server: the page of a site has none of its own. */
const OF_SERVER: readonly Page[] = [
  lazy("/ui/users", () => import("../access/UsersPage")),
  lazy("/ui/tokens", () => import("../access/TokensPage")),
];

/** The pages that there are here. */
export function usePages(): Page[] {
  useSession();
  const all = [...CORE, ...(pageSite() === null ? OF_SERVER : []), ...pagesOf(useExtensions())];
  const here = ofSites() ? "sites" : "gateway";
  return all.filter(({ at = here }) => at === here);
}

interface MenuLink {
  to: string;
  name: string;
  letter: string;
  button: boolean;
}

/** The links to the pages, in the order of the menu. */
export function useMenu(): MenuLink[] {
  return usePages()
    .flatMap(({ path, menu }) => (menu === undefined ? [] : [{ button: false, ...menu, to: path }]))
    .sort((one, other) => one.order - other.order);
}
