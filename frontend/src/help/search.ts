import { type HelpDocument, plainText } from "./document";

/** A section that has all words of a search. */
export interface Hit {
  page: string;
  pageTitle: string;
  id: string;
  title: string;
  /** The text around the first word. */
  excerpt: string;
}

/** The most results that are shown. */
const MOST = 30;
/** How much of the text is shown before and after the first word. */
const [BEFORE, AFTER] = [60, 140];

interface Searched extends Omit<Hit, "excerpt"> {
  text: string;
}

/** The sections of pages by their names, as they are searched. */
export function searched(pages: Iterable<[string, HelpDocument]>): Searched[] {
  return [...pages].flatMap(([page, { sections }]) =>
    sections.map(({ id, title, html }) => ({
      page,
      pageTitle: sections[0]?.title ?? page,
      id,
      title,
      text: plainText(html),
    })),
  );
}

/** The sections that have all words: first those that have them in their titles, then the shorter ones. */
export function search(query: string, sections: readonly Searched[]): Hit[] {
  const words = query.toLowerCase().split(/\s+/).filter(Boolean);
  if (words.length === 0) return [];
  return sections
    .map((section) => ({ section, score: scoreOf(section, words) }))
    .filter(({ score }) => score > 0)
    .sort((one, other) => other.score - one.score || one.section.text.length - other.section.text.length)
    .slice(0, MOST)
    .map(({ section: { text, ...section } }) => ({ ...section, excerpt: excerptOf(text, words) }));
}

/** 0 where a word is missing. */
function scoreOf({ title, pageTitle, text }: Searched, words: readonly string[]): number {
  const [inTitle, inPage, inText] = [title, pageTitle, text].map((each) => each.toLowerCase());
  let score = 0;
  for (const word of words) {
    if (inTitle?.includes(word)) score += 4;
    else if (inText?.includes(word)) score += 1;
    else if (!inPage?.includes(word)) return 0;
    if (inPage?.includes(word)) score += 1;
  }
  return score;
}

function excerptOf(text: string, words: readonly string[]): string {
  const lower = text.toLowerCase();
  const at = Math.max(0, ...words.slice(0, 1).map((word) => lower.indexOf(word)));
  const from = at <= BEFORE ? 0 : text.indexOf(" ", at - BEFORE) + 1;
  const until = text.length <= at + AFTER ? text.length : text.lastIndexOf(" ", at + AFTER);
  return `${from > 0 ? "… " : ""}${text.slice(from, until)}${until < text.length ? " …" : ""}`;
}
