import { jsonLanguage } from "@codemirror/lang-json";
import type { Diagnostic } from "@codemirror/lint";
import type { FieldError } from "./form/write";

type SyntaxNode = ReturnType<typeof jsonLanguage.parser.parse>["topNode"];

/**
 * The errors at their places in a JSON text: a field that is not in the text is marked at the message that it belongs to.
 * If the text is not JSON, the place is where it stops being JSON; not every browser's `JSON.parse` tells that.
 */
export function placeErrors(text: string, errors: readonly FieldError[]): Diagnostic[] {
  const top = jsonLanguage.parser.parse(text).topNode;
  const broken = firstBroken(top);
  return errors.map(({ path, detail }) => {
    const { from, to } = broken ?? find(top.firstChild ?? top, steps(path), text);
    const lineEnd = text.indexOf("\n", from);
    return {
      from,
      to: lineEnd < 0 ? to : Math.min(to, lineEnd),
      severity: "error",
      message: path === "" ? detail : `${path}: ${detail}`,
    };
  });
}

function steps(path: string): string[] {
  return path === "" ? [] : path.split(".");
}

function firstBroken(top: SyntaxNode): SyntaxNode | null {
  const cursor = top.cursor();
  do if (cursor.type.isError) return cursor.node;
  while (cursor.next());
  return null;
}

/** The last node on the way along the path: a property, an item or, where nothing is found, the node itself. */
function find(node: SyntaxNode, path: readonly string[], text: string): SyntaxNode {
  const [step, ...rest] = path;
  const value = node.name === "Property" ? node.lastChild : node;
  const next = step === undefined || value === null ? undefined : childAt(value, step, text);
  return next === undefined ? node : find(next, rest, text);
}

function childAt(value: SyntaxNode, step: string, text: string): SyntaxNode | undefined {
  // Of properties with the same name, the last one counts.
  if (value.name === "Object")
    return value.getChildren("Property").findLast((it) => nameOf(it, text) === step);
  return value.name === "Array" ? items(value)[Number(step)] : undefined;
}

function nameOf(property: SyntaxNode, text: string): unknown {
  const name = property.firstChild;
  return name === null ? null : JSON.parse(text.slice(name.from, name.to));
}

function items(array: SyntaxNode): SyntaxNode[] {
  const items: SyntaxNode[] = [];
  // Brackets and commas are nodes, too.
  for (let node = array.firstChild; node !== null; node = node.nextSibling) {
    if (/^\w/.test(node.name)) items.push(node);
  }
  return items;
}
