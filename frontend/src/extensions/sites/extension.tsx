import { useEffect } from "react";
import { setSitesServer } from "../../api/places";
import { useSession } from "../../api/session";
import type { Extension } from "../../extension/extension";
import { lazyPart } from "../../ui/lazyPart";
import { hub } from "./hub";

const Pending = lazyPart(() => import("./PendingStops"));

function PendingStops() {
  useSession();
  return hub.isHere() && <Pending />;
}

/** The page of a site is loaded as a page of its own: it shares nothing with those about all sites. */
function ToSite(): null {
  useEffect(() => window.location.replace(window.location.href), []);
  return null;
}

export const extension: Extension = {
  name: "sites",
  pages: [
    {
      path: "/",
      Page: lazyPart(() => import("./SitesOverviewPage")),
      menu: { name: "Overview", letter: "o", order: 0 },
      at: "sites",
    },
    {
      path: "/ui/sites",
      Page: lazyPart(() => import("./SitesPage")),
      menu: { name: "Sites", letter: "i", order: 10 },
      at: "sites",
    },
    {
      path: "/ui/map",
      Page: lazyPart(() => import("./SiteMapsPage")),
      menu: { name: "Map", letter: "m", order: 20 },
      at: "sites",
    },
    { path: "/ui/goals/:goalId", Page: lazyPart(() => import("./GoalAtSite")), at: "sites" },
    { path: "/sites/:site/*", Page: ToSite, at: "sites" },
  ],
  parts: { stops: PendingStops },
  start: () => setSitesServer(hub),
};
