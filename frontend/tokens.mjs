// Part of `npm run lint`: stylesheets and components use the scale of src/ui/tokens.ts, and nothing beside it.
import { readdirSync, readFileSync } from "node:fs";
import { SIZES, SPACES, WEIGHTS } from "./src/ui/tokens.ts";

/** Letters that grow with a screen, a picture or the text around them have no fixed size. */
const GROWS = /\b(inherit|[\d.]+(em|vmin|vh|vw|cqw|cqh))\b/;
const TOKENS = "ui/tokens.ts";
/** In rem; what is larger arranges a page. */
const LARGEST = Math.max(...SPACES);

/** What is wrong with one declaration of a stylesheet; null where nothing is. */
function wrongIn(property, value) {
  if (
    property === "font-size" &&
    !GROWS.test(value) &&
    !SIZES.some((size) => value === `var(--mantine-${size})`)
  )
    return "no size of the scale";
  if (property === "font-weight" && value !== "inherit" && !WEIGHTS.includes(Number(value)))
    return "no weight of the scale";
  if (/^((row-|column-)?gap|(padding|margin)(-[a-z-]+)?)$/.test(property))
    for (const [, number] of value.matchAll(/(?<![\w.-])([\d.]+)rem\b/g))
      if (!SPACES.includes(Number(number)) && Number(number) < LARGEST)
        return `${number}rem is no space of the scale`;
  return null;
}

const problems = [];
for (const file of readdirSync("src", { recursive: true }).filter((each) => /\.(css|tsx?)$/.test(each))) {
  const text = readFileSync(`src/${file}`, "utf8");
  if (file !== TOKENS)
    for (const [color] of text.matchAll(/(?<![\w&])#(?:[\da-f]{8}|[\da-f]{6}|[\da-f]{3,4})\b(?=["; ,)])/gi))
      problems.push(`src/${file}: ${color} is a colour of its own.`);
  if (file.endsWith(".css"))
    for (const [, property, value] of text.matchAll(/^\s*([a-z-]+): ([^;{}]+);/gm)) {
      const wrong = wrongIn(property, value);
      if (wrong !== null) problems.push(`src/${file}: ${property}: ${value}: ${wrong}.`);
    }
  else
    for (const [, weight] of text.matchAll(/\bfw=\{(\d+)\}/g))
      if (!WEIGHTS.includes(Number(weight)))
        problems.push(`src/${file}: fw={${weight}}: no weight of the scale.`);
}
process.stderr.write(problems.map((problem) => `${problem} See src/${TOKENS}.\n`).join(""));
process.exitCode = problems.length > 0 ? 1 : 0;
