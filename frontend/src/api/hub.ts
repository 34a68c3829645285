import { session } from "./session";

/** The pages of a hub itself, which are about the robots of all its sites: a name there has its site in front. */

/** Whether this page is one of them. The pages of a site are not. */
export function ofHub(): boolean {
  return session.state.hub;
}

interface Place {
  /** Null on every other page: all names are of one gateway. */
  site: string | null;
  /** What the paths of the site's API and pages begin with. */
  prefix: string;
  /** The name at the site. */
  name: string;
}

/** Where a robot or an action is: `/berlin/robot1` is `/robot1` of `berlin`, and `/berlin` is its robot `/`. */
export function placeOf(name: string): Place {
  if (!ofHub()) return { site: null, prefix: "", name };
  const [, site = "", ...own] = name.split("/");
  return { site, prefix: `/sites/${site}`, name: `/${own.join("/")}` };
}

/** The name of the hub for a name of a site. */
export function hubName(site: string, name: string): string {
  return `/${site}${name === "/" ? "" : name}`;
}

/** The id that an alert or an approval of a robot has at its site: those of two sites may be the same. */
export function ownId(id: string, robot: string): string {
  const { site } = placeOf(robot);
  return site === null ? id : id.slice(site.length + 1);
}
