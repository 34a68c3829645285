// Part of `npm run lint`: a folder of src imports only from itself and from folders that are listed before it. So no two
// folders import each other, and nothing that others build on knows what is built on it. An extension may import all of
// them, and nothing imports an extension but the list in extensions.ts; its tests go with it. The client is a package of its
// own: it imports only itself and its dependencies. And tests mock modules in tests/setup.ts alone: elsewhere, what another
// file has loaded before would go on with the module that it knows.
import { readdirSync, readFileSync } from "node:fs";
import { dirname, join, relative, sep } from "node:path";
import ts from "typescript";

const LAYERS = [
  // Transport: time, requests, events, and the state that they add up to.
  ...["clock", "api", "stream", "store"],
  // Components that know no robot.
  "ui",
  // What features share: all robots, what extensions can add, who uses the page, one goal in words.
  ...["fleet", "extension", "access", "goal", "stop"],
  // Features.
  ...["battery", "docking", "scene", "actions", "goals", "operations", "entries", "approvals"],
  ...["alerts", "notifications", "graph", "help"],
  // What puts features together.
  ...["pages/robot", "pages/overview", "pages/map", "pages/wall", "pages", "search", "layout"],
];

/** The layer of a file, as a place in the list: the innermost of its folders that is there; -1 for none. */
function layerOf(file) {
  const folder = dirname(file).split(sep).join("/");
  const name = LAYERS.find((each) => folder === each || folder.startsWith(`${each}/`));
  return LAYERS.indexOf(name);
}

/** The extension that a file is part of: `extensions/cameras`; null for none. */
function extensionOf(file) {
  return /^extensions\/[^/]+(?=\/)/.exec(file.split(sep).join("/"))?.[0] ?? null;
}

/** The files of a folder with what they import from beside them, as paths from the frontend's folder. */
function* importsIn(folder) {
  for (const file of readdirSync(folder, { recursive: true })) {
    if (!/\.tsx?$/.test(file)) continue;
    for (const { fileName } of ts.preProcessFile(readFileSync(join(folder, file), "utf8")).importedFiles)
      if (fileName.startsWith(".")) yield { file, imported: join(folder, dirname(file), fileName) };
  }
}

const problems = [];
for (const file of readdirSync("src", { recursive: true })) {
  const known = dirname(file) === "." || extensionOf(file) !== null || layerOf(file) >= 0;
  if (/\.tsx?$/.test(file) && !known) problems.push(`src/${file}: its folder is in no layer of layers.mjs.`);
}
for (const { file, imported } of importsIn("src")) {
  const target = relative("src", imported);
  const extension = extensionOf(target);
  if (extension !== null && extension !== extensionOf(file) && file !== "extensions.ts")
    problems.push(`src/${file} imports ${target}: only extensions.ts imports an extension.`);
  if (dirname(file) === "." || extensionOf(file) !== null) continue; // main.tsx starts everything
  if (target === "extensions") problems.push(`src/${file} imports extensions.ts: only main.tsx does.`);
  if (layerOf(target) > layerOf(file))
    problems.push(`src/${file} imports ${target}: layers.mjs lists ${LAYERS[layerOf(file)]} before it.`);
}
for (const { file, imported } of importsIn("tests")) {
  const extension = extensionOf(relative("src", imported));
  if (extension !== null && extension !== extensionOf(file))
    problems.push(`tests/${file} imports ${imported}: only tests/${extension} may, and goes with it.`);
}
for (const file of readdirSync("tests", { recursive: true }))
  if (
    /\.tsx?$/.test(file) &&
    file !== "setup.ts" &&
    /\bvi\.(do)?mock\(/i.test(readFileSync(join("tests", file), "utf8"))
  )
    problems.push(`tests/${file} mocks a module: do it in tests/setup.ts.`);

const { dependencies } = JSON.parse(readFileSync("client/package.json", "utf8"));
for (const file of readdirSync("client/src", { recursive: true })) {
  for (const { fileName } of ts.preProcessFile(readFileSync(join("client/src", file), "utf8"))
    .importedFiles) {
    const own = fileName.startsWith("./");
    const declared = Object.keys(dependencies).some((name) => `${fileName}/`.startsWith(`${name}/`));
    if (!own && !declared)
      problems.push(`client/src/${file} imports ${fileName}: it is no dependency in client/package.json.`);
  }
}
process.stderr.write(problems.map((problem) => `${problem}\n`).join(""));
process.exitCode = problems.length > 0 ? 1 : 0;
