import type { ComponentType } from "react";
import { ofHub } from "../api/hub";
import { pageSite } from "../api/site";
import { useExtensions } from "../extension/context";
import { type Page, pagesOf } from "../extension/extension";
import { lazyPart } from "../ui/lazyPart";
import OverviewPage from "./overview/OverviewPage";
import RobotPage from "./robot/RobotPage";

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
  { path: "/", Page: OverviewPage, menu: { name: "Overview", letter: "o", order: 0 } },
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
  // At a hub.
  lazy("/ui/sites", () => import("../sites/SitesPage"), {
    at: "sites",
    menu: { name: "Sites", letter: "i", order: 10 },
  }),
  lazy("/ui/map", () => import("./map/SiteMapsPage"), {
    at: "sites",
    menu: { name: "Map", letter: "m", order: 20 },
  }),
  lazy("/ui/goals/:goalId", () => import("../goals/GoalAtSite"), { at: "sites" }),
];

/** The login is that of the server: the page of a site has none of its own. */
const OF_SERVER: readonly Page[] = [
  lazy("/ui/users", () => import("../access/UsersPage")),
  lazy("/ui/tokens", () => import("../access/TokensPage")),
];

/** The pages that there are here. */
export function usePages(): Page[] {
  const all = [...CORE, ...(pageSite() === null ? OF_SERVER : []), ...pagesOf(useExtensions())];
  const here = ofHub() ? "sites" : "gateway";
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
