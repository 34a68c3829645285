import { ofHub } from "../api/hub";

interface Page {
  to: string;
  name: string;
  /** Goes to it after a g. */
  letter: string;
  /** Reached by a button of the header where there is room for the links to the others. */
  button?: true;
  /** Only on the pages of a hub about all sites, or everywhere else. */
  at?: "hub" | "gateway";
}

const PAGES: readonly Page[] = [
  { to: "/", name: "Overview", letter: "o" },
  { to: "/ui/sites", name: "Sites", letter: "i", at: "hub" },
  { to: "/ui/map", name: "Map", letter: "m" },
  { to: "/ui/goals", name: "Goals", letter: "g" },
  { to: "/ui/actions", name: "Actions", letter: "a", at: "gateway" },
  { to: "/ui/statistics", name: "Statistics", letter: "s" },
  { to: "/ui/automation", name: "Automatic docking", letter: "d", at: "gateway" },
  { to: "/ui/graph", name: "Graph", letter: "r", at: "gateway" },
  { to: "/ui/notifications", name: "Notifications", letter: "n", button: true },
];

/** The pages that there are here, in the order of the menu. */
export function pagesHere(): readonly Page[] {
  const here = ofHub() ? "hub" : "gateway";
  return PAGES.filter(({ at = here }) => at === here);
}
