import type { Http } from "@dock-gateway/client";
import { pageSite } from "./site";

/**
 * Where robots are. Most pages are about those of the gateway that serves them. A server of several sites has pages about
 * the robots of all of them, and serves the pages of each site, too: an extension knows it.
 */

/** Where a name leads. */
export interface Place {
  /** Null where all names are of one gateway. */
  site: string | null;
  /** What the paths of the site's API and pages begin with. */
  prefix: string;
  /** The name at the site. */
  name: string;
}

/** What came of a stop, for the reader. */
export interface StopNotice {
  color: string;
  title: string;
  message: string;
  /** When it goes by itself (ms). */
  autoClose: number | false;
}

/** A server of several sites. */
export interface SitesServer {
  /** What it is called, in the middle of a sentence. */
  name: string;
  /** Whether this page is about the robots of all sites. */
  isHere(): boolean;
  placeOf(name: string): Place;
  /** Stops robots by the names of this page, all of them for null; that a site was not reached is no failure. */
  stop(http: Http, by: string, robots: readonly string[] | null): Promise<StopNotice>;
  /** Throws a ClientError where it was not released. */
  release(http: Http, robot: string): Promise<void>;
}

let server: SitesServer | null = null;

/** Called once, before anything is shown. */
export function setSitesServer(known: SitesServer): void {
  server = known;
}

/** Whether this page is about the robots of several sites. */
export function ofSites(): boolean {
  return server?.isHere() ?? false;
}

/** Who stops the robots of this page; null where its own gateway does. */
export function stopsElsewhere(): SitesServer | null {
  return ofSites() || pageSite() !== null ? server : null;
}

/** Who releases the robots of this page; null where its own gateway does. */
export function releasesElsewhere(): SitesServer | null {
  return ofSites() ? server : null;
}

/** What the server of the sites is called. */
export function serverName(): string {
  return server?.name ?? "gateway";
}

/** Where a robot or an action is. */
export function placeOf(name: string): Place {
  return server?.isHere() ? server.placeOf(name) : { site: null, prefix: "", name };
}

/** The id that an alert or an approval of a robot has at its site: those of two sites may be the same. */
export function ownId(id: string, robot: string): string {
  const { site } = placeOf(robot);
  return site === null ? id : id.slice(site.length + 1);
}
