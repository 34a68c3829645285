import type { ComponentType } from "react";

/**
 * A feature that can be taken out: what it adds to the dashboard. The rooms below `extensions/` map over the list in
 * extensions.ts and know no extension by its name.
 */
export interface Extension {
  /** That of its folder, and of the gateway's extension. */
  name: string;
  pages?: readonly Page[];
  /** What it adds to pages that are not its own, by place. */
  parts?: { [Place in keyof Places]?: ComponentType<Places[Place]> };
}

/** A page below the header. */
export interface Page {
  /** Where it is: `/ui/statistics`. */
  path: string;
  Page: ComponentType;
  /** Its entry among the links to all pages. */
  menu?: MenuEntry;
}

export interface MenuEntry {
  name: string;
  /** Goes to the page after a g. */
  letter: string;
  /** Entries are sorted by it. */
  order: number;
}

/** The pages of extensions. */
export function pagesOf(extensions: readonly Extension[]): Page[] {
  return extensions.flatMap(({ pages = [] }) => pages);
}

/** What extensions add at a place, by their names. */
export function partsAt<Place extends keyof Places>(
  extensions: readonly Extension[],
  place: Place,
): [string, ComponentType<Places[Place]>][] {
  return extensions.flatMap(({ name, parts }) => {
    const Part = parts?.[place];
    return Part === undefined ? [] : [[name, Part as ComponentType<Places[Place]>]];
  });
}

/** The places for parts of extensions, and what a part there is given. */
export interface Places {
  /** Below what has to be done about a robot: the column beside its map. */
  robotColumn: OfRobot;
}

interface OfRobot {
  /** Its name, that of the configured robot included. */
  robot: string;
}
