/** The pages, and the letter that goes to each after a g. */
export const PAGES = [
  { to: "/", name: "Overview", letter: "o" },
  { to: "/ui/goals", name: "Goals", letter: "g" },
  { to: "/ui/actions", name: "Actions", letter: "a" },
  { to: "/ui/statistics", name: "Statistics", letter: "s" },
  { to: "/ui/automation", name: "Automatic docking", letter: "d" },
  { to: "/ui/graph", name: "Graph", letter: "r" },
] as const;
