import { readdirSync, readFileSync } from "node:fs";
import { join, relative, resolve } from "node:path";
import { describe, expect, it } from "vitest";
import { documentOf } from "../documentation";
import { FOR_CONTRIBUTORS } from "../src/help/pages";

const FRONTEND = resolve(import.meta.dirname, "..");
const DOCS = resolve(FRONTEND, "../docs");
const SOURCES = join(FRONTEND, "src");

const filesIn = (folder: string, end: RegExp) =>
  readdirSync(folder, { recursive: true, encoding: "utf8" })
    .filter((name) => end.test(name))
    .map((name) => join(folder, name));

const documents = new Map(
  filesIn(DOCS, /\.md$/).map((path) => [
    relative(DOCS, path).replace(/\.md$/, ""),
    documentOf(readFileSync(path, "utf8"), path),
  ]),
);

/** Whether there is a heading: `stop#the-latch`, or a page: `stop`. */
function isThere(link: string): boolean {
  const [name = "", heading] = link.split("#");
  const sections = documents.get(name)?.sections;
  return sections !== undefined && (heading === undefined || sections.some(({ id }) => id === heading));
}

/** The links to the help in the dashboard, each with its file. */
const links = filesIn(SOURCES, /\.tsx$/).flatMap((path) => {
  const source = readFileSync(path, "utf8");
  const found = [...source.matchAll(/ help="([^"]+)"|<HelpLink\s+to="([^"]+)"/g)];
  return found.map(([, help, to]): [file: string, link: string] => [
    relative(SOURCES, path),
    help ?? to ?? "",
  ]);
});

describe("the help of the dashboard", () => {
  it("is on the cards and pages", () => expect(links.length).toBeGreaterThan(15));

  it.each(links)("of %s leads to a heading: %s", (_, link) => expect(isThere(link)).toBe(true));

  it.each(links)("of %s can be taken out with it: %s", (file, link) => {
    const own = /^extensions\/([^/]+)\//.exec(file)?.[1];
    const other = /^extensions\/([^-#]+)/.exec(link)?.[1] ?? own;
    expect(other).toBe(own);
  });

  it.each([...documents])("has links on the page %s that lead to headings", (_, { sections }) => {
    const inside = sections.flatMap(({ html }) => [...html.matchAll(/href="\/ui\/help\/?([^"]*)"/g)]);
    const names = inside.map(([, link = ""]) =>
      link === "" || link.startsWith("#") ? `index${link}` : link,
    );
    expect(names.filter((link) => !isThere(link))).toEqual([]);
  });
});

it("leaves out of the search what the index lists for contributors", () => {
  const html = documents.get("index")?.sections.find(({ id }) => id === "contributors")?.html ?? "";
  expect([...html.matchAll(/"\/ui\/help\/([^"]+)"/g)].map(([, name]) => name)).toEqual(FOR_CONTRIBUTORS);
});

const page = (markdown: string) => documentOf(markdown, join(DOCS, "extensions/maps.md")).sections;

describe("a page of the documentation", () => {
  it("is its headings, each with what is below it", () => {
    expect(page("# Maps\n\nOne.\n\n## `WS /ws`: a *stream*\n\nTwo.\n")).toEqual([
      { id: "maps", title: "Maps", level: 1, html: "<p>One.</p>\n" },
      { id: "ws-ws-a-stream", title: "WS /ws: a stream", level: 2, html: "<p>Two.</p>\n" },
    ]);
  });

  it("names headings of the same text apart", () => {
    expect(page("# A\n## Stop\n## Stop\n").map(({ id }) => id)).toEqual(["a", "stop", "stop-1"]);
  });

  it("has links to pages and other servers; a file of the repository is only named", () => {
    const [section] = page(
      "# A\n[stop](../stop.md#the-latch) [here](#a) [all](../index.md) [away](https://ros.org) [file](../../Makefile) [gone](x.md)",
    );
    expect(section?.html).toBe(
      '<p><a href="/ui/help/stop#the-latch">stop</a> <a href="/ui/help/extensions/maps#a">here</a> ' +
        '<a href="/ui/help">all</a> <a href="https://ros.org" target="_blank" rel="noreferrer">away</a> file gone</p>\n',
    );
  });

  it("shows HTML as text, and runs no link that is a script", () => {
    const [section] = page(
      "# A\n<script>alert(1)</script>\n\nx <img src=y onerror=z> [a](javascript:alert)\n",
    );
    expect(section?.html).not.toMatch(/<(?:script|img)|href/);
    expect(section?.html).toContain("&lt;script&gt;");
  });

  it("leaves out comments and pictures", () => {
    expect(page("# A\n<!-- not run -->\n![A robot](x.png)\n")[0]?.html).not.toMatch(/not run|robot/);
  });
});
