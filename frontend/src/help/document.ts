/** A heading of a page of the documentation. */
export interface HelpHeading {
  /** Its name in links, as GitHub makes it. */
  id: string;
  title: string;
  /** 1 for the page's own. */
  level: number;
}

/** A heading with what stands below it, up to the next one. */
export interface HelpSection extends HelpHeading {
  html: string;
}

/** A page of the documentation, ready to be shown. */
export interface HelpDocument {
  /** The first one is the page's own. */
  sections: HelpSection[];
}

const ENTITIES: Record<string, string> = {
  "&lt;": "<",
  "&gt;": ">",
  "&quot;": '"',
  "&#39;": "'",
  "&amp;": "&",
};

/** The text of HTML. */
export function plainText(html: string): string {
  return html
    .replaceAll(/<\/(?:p|li|t[dh]|pre)>/g, " ")
    .replaceAll(/<[^>]*>/g, "")
    .replaceAll(/&(?:lt|gt|quot|#39|amp);/g, (entity) => ENTITIES[entity] ?? entity)
    .replaceAll(/\s+/g, " ")
    .trim();
}
