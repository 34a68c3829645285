/**
 * Where a page is: a server of several sites has the dashboard of each below `/sites/{site}`, and there the site's own API, too. The
 * login, its users and the files of the dashboard are always those of the server.
 */

const PREFIX = /^\/sites\/([a-z][a-z0-9_]{0,39})(?=\/)/;

/** The site whose page this is; null at a gateway, and on the pages about all sites. */
export function pageSite(): string | null {
  // Tests without a page have no location.
  return PREFIX.exec(globalThis.location?.pathname ?? "/")?.[1] ?? null;
}

/** What the paths of pages and of the API begin with: `/sites/berlin`; empty at a gateway, and on the pages about all sites. */
export function sitePrefix(): string {
  const site = pageSite();
  return site === null ? "" : `/sites/${site}`;
}

/** A path of the API as the browser asks for it. */
export function apiPath(path: string): string {
  return sitePrefix() + path;
}

/** The address of the API, for a terminal: `https://robots.example/sites/berlin`. */
export function apiAddress(): string {
  return window.location.origin + sitePrefix();
}

/** The options of a request about the login, which is that of the server on the page of a site, too. */
export function atServer(): { baseUrl?: string } {
  return pageSite() === null ? {} : { baseUrl: window.location.origin };
}

/** A key of the browser's storage, for what names robots: each site has its own. */
export function siteKey(key: string): string {
  const site = pageSite();
  return site === null ? key : `${key} ${site}`;
}
