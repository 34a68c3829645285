interface Page {
  to: string;
  name: string;
  /** Goes to it after a g. */
  letter: string;
  /** Reached by a button of the header where there is room for the links to the others. */
  button?: true;
}

export const PAGES: readonly Page[] = [
  { to: "/", name: "Overview", letter: "o" },
  { to: "/ui/map", name: "Map", letter: "m" },
  { to: "/ui/goals", name: "Goals", letter: "g" },
  { to: "/ui/actions", name: "Actions", letter: "a" },
  { to: "/ui/statistics", name: "Statistics", letter: "s" },
  { to: "/ui/automation", name: "Automatic docking", letter: "d" },
  { to: "/ui/graph", name: "Graph", letter: "r" },
  { to: "/ui/notifications", name: "Notifications", letter: "n", button: true },
];
