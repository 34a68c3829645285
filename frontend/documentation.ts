import { existsSync } from "node:fs";
import { dirname, join, relative } from "node:path";
import { Marked, type Token, type Tokens } from "marked";
import type { Plugin } from "vite";
import { type HelpDocument, plainText } from "./src/help/document.ts";

/** The documentation, which the dashboard shows as its help. */
const DOCS = join(import.meta.dirname, "..", "docs");

const PAGE = /\.md(?:\?(headings))?$/;

/** Lets the dashboard import a page of the documentation (`HelpDocument`), and only its headings with `?headings`. */
export function documentation(): Plugin {
  return {
    name: "documentation",
    enforce: "pre",
    transform(markdown, id) {
      const match = PAGE.exec(id);
      if (match === null) return null;
      const { sections } = documentOf(markdown, id.replace(/\?.*/, ""));
      const headings = sections.map(({ html: _, ...heading }) => heading);
      const value = JSON.stringify(match[1] === undefined ? { sections } : headings);
      return { code: `export default JSON.parse(${JSON.stringify(value)});`, map: null, moduleType: "js" };
    },
  };
}

/**
 * A page of the documentation as HTML. All of its tags are made here: HTML that stands in the page is shown as text.
 *
 * @param file The path of the page, from which its links lead.
 */
export function documentOf(markdown: string, file: string): HelpDocument {
  const marked = new Marked({
    renderer: {
      html: ({ text }) => (text.startsWith("<!--") ? "" : escaped(text)),
      image: () => "",
      code: ({ text }) => `<pre tabindex="0"><code>${escaped(text)}</code></pre>`,
      link({ href, tokens }) {
        const text = this.parser.parseInline(tokens);
        const to = addressOf(href, file);
        if (to === null) return text;
        return `<a href="${escaped(to)}"${to.startsWith("/") ? "" : ' target="_blank" rel="noreferrer"'}>${text}</a>`;
      },
      table({ header, rows }) {
        const row = (tag: string, cells: Tokens.TableCell[]) =>
          `<tr>${cells.map(({ tokens }) => `<${tag}>${this.parser.parseInline(tokens)}</${tag}>`).join("")}</tr>`;
        const body = rows.map((cells) => row("td", cells)).join("");
        // Wide tables scroll, also by the keyboard.
        return `<div tabindex="0"><table><thead>${row("th", header).replaceAll("<th></th>", "<td></td>")}</thead><tbody>${body}</tbody></table></div>`;
      },
    },
  });
  const used = new Map<string, number>();
  const parts: { heading: Tokens.Heading; below: Token[] }[] = [];
  for (const token of marked.lexer(markdown)) {
    if (token.type === "heading") parts.push({ heading: token as Tokens.Heading, below: [] });
    else parts.at(-1)?.below.push(token);
  }
  const sections = parts.map(({ heading, below }) => {
    const title = plainText(marked.Parser.parseInline(heading.tokens, marked.defaults));
    const name = slug(title);
    const before = used.get(name) ?? 0;
    used.set(name, before + 1);
    const id = before === 0 ? name : `${name}-${before}`;
    return { id, title, level: heading.depth, html: marked.parser(below) };
  });
  return { sections };
}

/** The name of a heading in links, as GitHub makes it. */
function slug(title: string): string {
  return title
    .toLowerCase()
    .replaceAll(/[^\p{L}\p{N}_\- ]/gu, "")
    .replaceAll(" ", "-");
}

/** Where a link leads: to a page of the help or to another server. Null for files of the repository, which are not there. */
function addressOf(href: string, file: string): string | null {
  if (/^https?:/.test(href)) return href;
  const [path = "", heading] = href.split("#");
  const target = path === "" ? file : join(dirname(file), path);
  const page = relative(DOCS, target);
  if (page.startsWith("..") || !page.endsWith(".md") || !existsSync(target)) return null;
  const name = page === "index.md" ? "" : `/${page.replace(/\.md$/, "")}`;
  return `/ui/help${name}${heading === undefined ? "" : `#${heading}`}`;
}

function escaped(text: string): string {
  return text
    .replaceAll("&", "&amp;")
    .replaceAll("<", "&lt;")
    .replaceAll(">", "&gt;")
    .replaceAll('"', "&quot;");
}
