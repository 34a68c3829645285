import { readdirSync, readFileSync } from "node:fs";
import { basename, dirname, join, resolve } from "node:path";
import { expect, it } from "vitest";

const FRONTEND = resolve(import.meta.dirname, "..");
const MANTINE = join(FRONTEND, "node_modules/@mantine");
const CORE = join(MANTINE, "core/esm");
const ALWAYS = ["baseline", "default-css-variables", "global"];

const read = (path: string) => readFileSync(path, "utf8");

/** The files below a folder whose names end so. */
function filesIn(folder: string, end: RegExp): string[] {
  const names = readdirSync(folder, { recursive: true, encoding: "utf8" });
  return names.filter((name) => end.test(name)).map((name) => join(folder, name));
}

/** What a file imports from another, which a pattern matches: names by where they come from. */
function importsOf(path: string, from: RegExp): [name: string, from: string][] {
  const found = [...read(path).matchAll(/import\s+(?!type)(?:\{([^}]*)\}|\w+) from "([^"]+)"/g)];
  return found
    .filter(([, , origin = ""]) => from.test(origin))
    .flatMap(([, names = "default", origin = ""]) =>
      names.split(",").map((name): [string, string] => [name.trim().split(" as ")[0] ?? "", origin]),
    );
}

/** The files that a file of Mantine needs, itself included. */
function reach(path: string, seen: Set<string>): void {
  if (seen.has(path)) return;
  seen.add(path);
  for (const [, from] of importsOf(path, /^\./)) reach(resolve(dirname(path), from), seen);
}

/** The stylesheets of the components that the dashboard, or another package of Mantine, uses, and of those within them. */
function neededSheets(): Set<string> {
  const users = [
    ...filesIn(join(FRONTEND, "src"), /\.tsx?$/),
    ...["notifications", "spotlight"].flatMap((name) => filesIn(join(MANTINE, name, "esm"), /\.mjs$/)),
  ];
  const used = new Set(users.flatMap((path) => importsOf(path, /^@mantine\/core$/)).map(([name]) => name));
  const files = new Set<string>();
  for (const [name, from] of importsOf(join(CORE, "index.mjs"), /^\./)) {
    if (used.has(name)) reach(resolve(CORE, from), files);
  }
  const modules = [...files].filter((path) => path.endsWith(".module.mjs"));
  return new Set(modules.map((path) => basename(path, ".module.mjs")));
}

it("imports the stylesheets of the components that are used, in Mantine's order, and no others", () => {
  const styles = read(join(FRONTEND, "src/layout/styles.ts"));
  const imported = [...styles.matchAll(/@mantine\/core\/styles\/([\w-]+)\.css/g)].map(
    ([, name]) => name ?? "",
  );
  const all = read(join(MANTINE, "core/styles.css"));
  const place = (name: string) => all.indexOf(read(join(MANTINE, `core/styles/${name}.css`)).trim());
  const needed = [...ALWAYS, ...neededSheets()];
  expect(needed.filter((name) => place(name) < 0)).toEqual([]);
  expect(imported).toEqual(needed.sort((one, other) => place(one) - place(other)));
});
