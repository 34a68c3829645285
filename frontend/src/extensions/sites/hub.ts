import type { Place, SitesServer } from "../../api/places";
import { session } from "../../api/session";
import { pageSite } from "../../api/site";
import { releaseSites, stopSites } from "./requests";
import { noticeOf } from "./stops";

/** A hub. Its own pages are about the robots of all its sites: a name there has its site in front. */
export const hub: SitesServer = {
  name: "hub",
  isHere: () => pageSite() === null && (session.state as { hub?: boolean }).hub === true,
  placeOf,
  stop: async (http, by, robots) => {
    // Also from the page of a site: a hub repeats it to a site that it does not reach.
    const site = pageSite();
    const names = site === null ? (robots ?? []) : (robots ?? ["/"]).map((name) => hubName(site, name));
    return noticeOf(await stopSites(http, by, names));
  },
  release: releaseSites,
};

/** `/berlin/robot1` is `/robot1` of `berlin`, and `/berlin` is its robot `/`. */
function placeOf(name: string): Place {
  const [, site = "", ...own] = name.split("/");
  return { site, prefix: `/sites/${site}`, name: `/${own.join("/")}` };
}

/** The name of the hub for a name of a site. */
export function hubName(site: string, name: string): string {
  return `/${site}${name === "/" ? "" : name}`;
}
