import type { HelpDocument } from "./document";

const LOADS = import.meta.glob<HelpDocument>("../../../docs/{*,extensions/*}.md", { import: "default" });

/** The page that leads to all others. */
export const INDEX = "index";

const loads = new Map(Object.entries(LOADS).map(([path, load]) => [nameOf(path), load]));

/** The name of a page, from the path of its file. */
export function nameOf(path: string): string {
  return path.replace(/^.*\/docs\/|\.md$/g, "");
}

/** The name of each page, as it stands in addresses: `stop`, `extensions/maps`. */
export const PAGE_NAMES: readonly string[] = [...loads.keys()];

/** The pages for those who change the gateway: shown, but not found by those who use it. */
export const FOR_CONTRIBUTORS: readonly string[] = [
  "architecture",
  "write-an-extension",
  "decisions",
  "performance",
  "reports",
];

/** Loads a page; null where there is none of this name. */
export async function loadPage(name: string): Promise<HelpDocument | null> {
  return (await loads.get(name)?.()) ?? null;
}

export function helpPath(name: string, heading?: string): string {
  return `/ui/help${name === INDEX ? "" : `/${name}`}${heading === undefined ? "" : `#${heading}`}`;
}
