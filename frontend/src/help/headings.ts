import type { HelpHeading } from "./document";
import { FOR_CONTRIBUTORS, helpPath, nameOf } from "./pages";

const FOUND = import.meta.glob<HelpHeading[]>("../../../docs/{*,extensions/*}.md", {
  eager: true,
  import: "default",
  query: "?headings",
});

/** The headings of the help: where they are, what they say, and the title of their page. */
export const HEADINGS = Object.entries(FOUND).flatMap(([path, headings]) => {
  const name = nameOf(path);
  if (FOR_CONTRIBUTORS.includes(name)) return [];
  return headings.map(({ id, title, level }) => ({
    to: helpPath(name, level === 1 ? undefined : id),
    title,
    level,
    page: headings[0]?.title ?? "",
  }));
});
