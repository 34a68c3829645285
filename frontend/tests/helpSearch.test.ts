import { describe, expect, it } from "vitest";
import type { HelpDocument } from "../src/help/document";
import { plainText } from "../src/help/document";
import { search, searched } from "../src/help/search";

const section = (id: string, title: string, html: string) => ({ id, title, level: 2, html });
const stop: HelpDocument = {
  sections: [
    section("stop", "Stop", "<p>Stops a robot.</p>"),
    section("the-latch", "The latch", "<p>A stopped robot <em>stays</em> where it is &amp; waits.</p>"),
    section("the-release", "The release", "<p>Ends the latch of a robot.</p>"),
  ],
};
const long: HelpDocument = {
  sections: [section("maps", "Maps", `<p>${"word ".repeat(100)}needle${" word".repeat(100)}</p>`)],
};
const sections = searched([
  ["stop", stop],
  ["extensions/maps", long],
]);
const found = (query: string) => search(query, sections).map(({ id }) => id);

describe("the search in the help", () => {
  it("finds sections that have all words, in the title first", () => {
    expect(found("latch")).toEqual(["the-latch", "the-release"]);
    expect(found("robot latch")).toEqual(["the-latch", "the-release"]);
    expect(found("latch nothing")).toEqual([]);
  });

  it("takes the page's title into account, whatever the case", () => {
    expect(found("STOP ends")).toEqual(["the-release"]);
  });

  it("finds nothing for no words", () => expect(found("  ")).toEqual([]));

  it("shows the text around the first word, in whole words", () => {
    const [hit] = search("needle", sections);
    expect(hit?.excerpt).toMatch(/^… (?:word )+needle(?: word)+ …$/);
    expect(hit?.excerpt.length).toBeLessThan(230);
    expect(search("waits", sections)[0]?.excerpt).toBe("A stopped robot stays where it is & waits.");
  });
});

it("is text without tags", () => {
  expect(plainText("<p>a &lt;b&gt;</p><p>c<code>d</code></p>")).toBe("a <b> cd");
});
